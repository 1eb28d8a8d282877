#include "devices/cpu/cpu_device.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "devices/cpu/dvr_packet.h"
#include "devices/cpu/march.h"
#include "devices/cpu/mesh_walk.h"
#include "devices/cpu/packet_trace.h"
#include "kernels/integrators.h"
#include "kernels/traverse.h"

namespace spinel {
namespace {

using kernels::Connection;
using kernels::Hit;
using kernels::PathState;
using kernels::PixelSample;

// Numbers of kernels/integrator_table.h.
constexpr std::uint32_t path_integrator = 0;
constexpr std::uint32_t single_scatter_integrator = 5;
constexpr std::uint32_t dvr_integrator = 6;

bool same_bits(const kernels::MarchSettings& a, const kernels::MarchSettings& b) {
    using Bits = std::array<std::uint32_t, sizeof a / sizeof(std::uint32_t)>;
    return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

struct PixelIndex {
    glm::uvec2 pixel;
    std::uint32_t sample;
};

// Samples that are neighbours in the picture or of one pixel, as many as rays go in a packet.
using Group = std::array<PixelIndex, packet_size>;

void set_ray(RayLanes& lanes, std::size_t i, const kernels::Ray& ray) {
    lanes.origin.x[i] = ray.origin.x, lanes.origin.y[i] = ray.origin.y, lanes.origin.z[i] = ray.origin.z;
    lanes.direction.x[i] = ray.direction.x, lanes.direction.y[i] = ray.direction.y;
    lanes.direction.z[i] = ray.direction.z;
}

// The pixels of a tile in blocks of 4×2, so that a group of them is as compact as its sample count lets it be.
std::vector<glm::uvec2> pixels_in_blocks(const Crop& tile) {
    std::vector<glm::uvec2> pixels;
    for (int y = tile.lower.y; y < tile.upper.y; y += 2)
        for (int x = tile.lower.x; x < tile.upper.x; x += 4)
            for (int i = 0; i < 8; ++i)
                if (const ivec2 p(x + i % 4, y + i / 4); p.x < tile.upper.x && p.y < tile.upper.y)
                    pixels.emplace_back(p);
    return pixels;
}

class CpuDevice : public Device {
  public:
    Result<void> load(const CompiledScene& scene) override {
        scene_ = &scene;
        march_.reset();
        // Scenes that were compiled for `dvr` have a transfer function.
        dvr_ = scene.dvr.table_size > 0 && scene.dvr.shortcuts ? DvrPackets::make(scene, scene.dvr) : nullptr;
        view_ = scene.view();
        packets_ =
            !scene.voxel_grids.empty() || std::any_of(scene.meshes.begin(), scene.meshes.end(), walks_in_packets);
        return {};
    }

    Result<void> render(const RenderPass& pass, FilmBuffer& film, const std::atomic<bool>& stop) override {
        prepare(pass);
        const ivec2 tiles = tile_count(film);
        std::atomic<std::uint64_t> bound_reached{0}, not_finite{0};
        parallel_for(std::size_t(tiles.x) * std::size_t(tiles.y), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t tile = begin; tile < end; ++tile) {
                if (pass.finished_tiles && (*pass.finished_tiles)[tile]) continue;
                render_tile(pass, tile_crop(film, int(tile)), film, stop, bound_reached, not_finite);
            }
        });
        film.bound_reached += bound_reached;
        film.not_finite += not_finite;
        return {};
    }

  private:
    // What an integrator's shortcuts need is made by the first pass.
    void prepare(const RenderPass& pass) {
        const kernels::MarchSettings& march = pass.settings.march;
        if (pass.integrator == single_scatter_integrator && march.shortcuts &&
            (!march_ || !same_bits(march_->settings(), march)))
            march_ = std::make_unique<MarchShortcuts>(*scene_, march);
    }

    void render_tile(const RenderPass& pass, const Crop& tile, FilmBuffer& film, const std::atomic<bool>& stop,
                     std::atomic<std::uint64_t>& bound_reached, std::atomic<std::uint64_t>& not_finite) const {
        Group group;
        std::size_t size = 0;
        const auto flush = [&] {
            if (size == 0) return;
            std::array<PixelSample, packet_size> samples;
            integrate(pass, group, size, samples);
            for (std::size_t i = 0; i < size; ++i) {
                bound_reached += samples[i].bound_reached;
                not_finite += !film.at(int(group[i].pixel.x), int(group[i].pixel.y)).add(samples[i]);
            }
            size = 0;
        };
        for (const glm::uvec2 pixel : pixels_in_blocks(tile))
            for (std::uint32_t i = 0; i < pass.sample_count; ++i) {
                group[size++] = {pixel, pass.first_sample + i};
                if (size < group.size()) continue;
                if (stop.load(std::memory_order_relaxed)) return;
                flush();
            }
        flush();
    }

    // A group is nothing but company for the rays: what a sample comes to does not depend on the others.
    void integrate(const RenderPass& pass, const Group& group, std::size_t size,
                   std::array<PixelSample, packet_size>& samples) const {
        if (pass.integrator == dvr_integrator && dvr_ && !dvr_->wants_hits() && !(view_.camera.lens_radius > 0))
            return volumes(pass, group, size, samples);
        PathState states[packet_size];
        Hit hits[packet_size];
        for (std::size_t i = 0; i < size; ++i)
            states[i] = kernels::path_generate(view_, pass.settings, group[i].pixel, group[i].sample);
        const bool together = packets_ && size > 1;
        if (together) {
            kernels::Ray rays[packet_size];
            for (std::size_t i = 0; i < packet_size; ++i) rays[i] = states[std::min(i, size - 1)].ray;
            cpu_trace_closest8(view_, rays, (1u << size) - 1, kernels::TRACE_ALL, hits);
        } else {
            for (std::size_t i = 0; i < size; ++i) hits[i] = kernels::path_extend(view_, states[i]);
        }
        if (pass.integrator == path_integrator && together) {
            first_vertices(pass.settings, states, hits, size);
            for (std::size_t i = 0; i < size; ++i) {
                if (states[i].flags & kernels::PATH_ALIVE)
                    kernels::path_follow(view_, pass.settings, states[i], kernels::path_extend(view_, states[i]));
                samples[i] = kernels::path_sample(states[i]);
            }
            return;
        }
        if (pass.integrator == dvr_integrator && dvr_) {
            RayLanes rays;
            Float8 start = splat(0.0f);
            for (std::size_t i = 0; i < packet_size; ++i) {
                PathState& state = states[std::min(i, size - 1)];
                set_ray(rays, i, state.ray);
                if (dvr_->settings().jitter) start[i] = kernels::sampler_1d(state.numbers);
            }
            return dvr_->render(rays, start, hits, int(size), samples.data());
        }
        if (pass.integrator == single_scatter_integrator && pass.settings.march.shortcuts) {
            for (std::size_t i = 0; i < size; ++i)
                samples[i] = march_->sample(states[i].ray, states[i].inside, hits[i], states[i].numbers);
            return;
        }
        for (std::size_t i = 0; i < size; ++i)
            samples[i] = kernels::integrate(view_, pass.settings, pass.integrator, states[i], hits[i]);
    }

    // Rays that no surface is in the way of, begun as path_generate() begins them.
    void volumes(const RenderPass& pass, const Group& group, std::size_t size,
                 std::array<PixelSample, packet_size>& samples) const {
        Uint8 x, y, index;
        for (std::size_t i = 0; i < packet_size; ++i) {
            const PixelIndex& at = group[std::min(i, size - 1)];
            x[i] = at.pixel.x, y[i] = at.pixel.y, index[i] = at.sample;
        }
        SamplerLanes numbers = make_sampler8(x, y, index, pass.settings.seed);
        const Pair8 u_film = sampler_2d8(numbers);
        numbers.dimension = 3;  // beyond the lens and the hero channel of paths
        const Float8 start = dvr_->settings().jitter ? sampler_1d8(numbers) : splat(0.0f);
        dvr_->render(camera_rays8(view_.camera, x, y, u_film), start, nullptr, int(size), samples.data());
    }

    // The first step of path_follow for all, so that their shadow rays go together too.
    void first_vertices(const kernels::PathSettings& settings, PathState* states, const Hit* hits,
                        std::size_t size) const {
        Connection connections[packet_size];
        kernels::Ray rays[packet_size];
        unsigned asked = 0;
        for (std::size_t i = 0; i < size; ++i) {
            kernels::path_beside(view_, settings, states[i], hits[i]);
            connections[i] = kernels::path_shade(view_, settings, states[i], hits[i]);
            rays[i] = connections[i].ray;
            asked |= unsigned(connections[i].valid) << i;
        }
        for (std::size_t i = size; i < packet_size; ++i) rays[i] = rays[0];
        unsigned clear = asked & ~cpu_trace_any8(view_, rays, asked, kernels::TRACE_SOLID);
        for (; clear; clear &= clear - 1) {
            const int i = std::countr_zero(clear);
            states[i].radiance += kernels::clamped(settings, states[i].bounces,
                                                   kernels::path_connect(view_, settings, states[i], connections[i]));
        }
    }

    const CompiledScene* scene_ = nullptr;
    kernels::SceneView view_ = {};
    std::unique_ptr<MarchShortcuts> march_;
    std::unique_ptr<DvrPackets> dvr_;
    bool packets_ = false;
};

}  // namespace

std::unique_ptr<Device> make_cpu_device() { return std::make_unique<CpuDevice>(); }

}  // namespace spinel
