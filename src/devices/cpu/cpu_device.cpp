#include "devices/cpu/cpu_device.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "devices/cpu/dvr_packet.h"
#include "devices/cpu/march.h"
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

struct PixelIndex {
    glm::uvec2 pixel;
    std::uint32_t sample;
};

// Samples that are neighbours in the picture or of one pixel, as many as rays go in a packet.
using Group = std::array<PixelIndex, packet_size>;

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
        packets_ = !scene.voxel_grids.empty();
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
            (!march_ || std::memcmp(&march_->settings(), &march, sizeof march) != 0))
            march_ = std::make_unique<MarchShortcuts>(*scene_, march);
    }

    void render_tile(const RenderPass& pass, const Crop& tile, FilmBuffer& film, const std::atomic<bool>& stop,
                     std::atomic<std::uint64_t>& bound_reached, std::atomic<std::uint64_t>& not_finite) const {
        Group group;
        std::size_t size = 0;
        const auto flush = [&] {
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
        if (pass.integrator == dvr_integrator && dvr_ && !dvr_->wants_hits())
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
            kernels::Ray rays[packet_size];
            kernels::Sampler numbers[packet_size];
            for (std::size_t i = 0; i < size; ++i) {
                rays[i] = states[i].ray;
                numbers[i] = states[i].numbers;
            }
            return dvr_->render(rays, hits, numbers, int(size), samples.data());
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
        kernels::Ray rays[packet_size];
        kernels::Sampler numbers[packet_size];
        for (std::size_t i = 0; i < size; ++i) {
            numbers[i] = kernels::make_sampler(group[i].pixel, group[i].sample, pass.settings.seed);
            const glm::vec2 u_film = kernels::sampler_2d(numbers[i]);
            const glm::vec2 u_lens = kernels::sampler_2d(numbers[i]);
            numbers[i].dimension += 1;  // the hero channel of paths
            rays[i] = kernels::camera_ray(view_.camera, group[i].pixel, u_film, u_lens);
        }
        dvr_->render(rays, nullptr, numbers, int(size), samples.data());
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
