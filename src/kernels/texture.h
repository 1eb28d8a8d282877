#ifndef SPINEL_KERNELS_TEXTURE_H
#define SPINEL_KERNELS_TEXTURE_H
// Texture look-ups from plain buffers: RGBA texels in words, or a procedural checker. No filtering over the pixel's
// footprint: the samples of a pixel do that.
#include "scene_view.h"
KERNELS_BEGIN

// Exact sRGB decoding (IEC 61966-2-1).
FN float srgb_to_linear(float x) { return x <= 0.04045f ? x / 12.92f : pow((x + 0.055f) / 1.055f, 2.4f); }

FN int wrap_coordinate(int i, int size, uint wrap) {
    if (wrap == WRAP_CLAMP) return clamp(i, 0, size - 1);
    int period = wrap == WRAP_MIRROR ? 2 * size : size;
    int r = i % period;
    if (r < 0) r += period;
    return r < size ? r : 2 * size - 1 - r;
}

// Linear RGBA of one texel; (x, y) may lie outside, row 0 is the top.
FN vec4 texel_at(const_in(SceneView) scene, const_in(Texture) t, int x, int y) {
    uint index =
        uint(wrap_coordinate(y, int(t.height), t.wrap_v)) * t.width + uint(wrap_coordinate(x, int(t.width), t.wrap_u));
    if (t.kind == TEXTURE_RGBA16F) {
        vec2 rg = unpackHalf2x16(scene.words.at[t.word_first + 2u * index]);
        vec2 ba = unpackHalf2x16(scene.words.at[t.word_first + 2u * index + 1u]);
        return vec4(rg.x, rg.y, ba.x, ba.y);
    }
    uint w = scene.words.at[t.word_first + index];
    vec4 c =
        vec4(float(w & 255u), float((w >> 8u) & 255u), float((w >> 16u) & 255u), float(w >> 24u)) * (1.0f / 255.0f);
    if (t.srgb != 0u) return vec4(srgb_to_linear(c.x), srgb_to_linear(c.y), srgb_to_linear(c.z), c.w);
    return c;
}

// A place on a face of a cube, which hits tell along the axes axis + 1 and axis + 2 (cyclic), as one who stands before
// the face with +y up sees it, u to the right and v up. From above and from below, u runs along +x; v runs along −z on
// the top and along +z on the bottom.
FN vec2 upright_uv(vec2 uv, uint face) {
    if (face == 0u) return vec2(uv.y, uv.x);
    if (face == 1u) return vec2(1.0f - uv.y, uv.x);
    if (face == 2u) return vec2(uv.y, uv.x);
    if (face == 3u) return vec2(uv.y, 1.0f - uv.x);
    if (face == 4u) return vec2(1.0f - uv.x, uv.y);
    return uv;
}

// A picture of its own on every face: a rectangle of an atlas, whose neighbours are not looked at.
FN vec4 face_texture_at(const_in(SceneView) scene, const_in(Texture) t, vec2 uv, uint face) {
    vec2 st = clamp(upright_uv(uv, face), vec2(0.0f), vec2(1.0f));
    uint first = t.face_first + 4u * face;
    int left = int(scene.words.at[first]);
    int top = int(scene.words.at[first + 1u]);
    int right = left + int(scene.words.at[first + 2u]) - 1;
    int bottom = top + int(scene.words.at[first + 3u]) - 1;
    float x = float(left) + st.x * float(right - left + 1);
    float y = float(top) + (1.0f - st.y) * float(bottom - top + 1);
    if (t.filter_kind == FILTER_NEAREST) return texel_at(scene, t, min(int(x), right), min(int(y), bottom));
    x -= 0.5f;
    y -= 0.5f;
    int i = int(floor(x));
    int j = int(floor(y));
    float a = x - float(i);
    float b = y - float(j);
    int i0 = max(i, left);
    int i1 = min(i + 1, right);
    int j0 = max(j, top);
    int j1 = min(j + 1, bottom);
    vec4 upper = mix(texel_at(scene, t, i0, j0), texel_at(scene, t, i1, j0), a);
    vec4 lower = mix(texel_at(scene, t, i0, j1), texel_at(scene, t, i1, j1), a);
    return mix(upper, lower, b);
}

// Where there is one set of texture coordinates only, it serves as the second as well.
FN vec4 both_uvs(vec2 uv) { return vec4(uv.x, uv.y, uv.x, uv.y); }

// uvs: two sets of texture coordinates (u, v, u, v); (0,0) is the lower left corner of the image. `face` of a cube that
// they lie on, for textures that differ by face; NONE: there is none.
FN vec4 texture_at(const_in(SceneView) scene, uint index, vec4 uvs, uint face) {
    RECORD(Texture) t = scene.textures.at[index];
    vec2 uv = t.uv_set == 0u ? vec2(uvs.x, uvs.y) : vec2(uvs.z, uvs.w);
    if (t.face_first != NONE) return face_texture_at(scene, t, uv, min(face, 5u));
    vec2 st = vec2(dot(t.row_u, uv), dot(t.row_v, uv)) + t.offset;
    if (t.kind == TEXTURE_CHECKER) {
        // Beyond this a float has no fraction left, and int no value.
        if (!(abs(st.x) < 1.0e6f) || !(abs(st.y) < 1.0e6f)) return vec4(0.5f * (t.color_a + t.color_b), 1.0f);
        int parity = (int(floor(st.x)) + int(floor(st.y))) & 1;
        return vec4(parity == 0 ? t.color_a : t.color_b, 1.0f);
    }
    float x = st.x * float(t.width);
    float y = (1.0f - st.y) * float(t.height);
    // Far outside, float coordinates lose their fraction and int conversion its definition.
    if (!(abs(x) < 1.0e9f) || !(abs(y) < 1.0e9f)) return vec4(0.0f, 0.0f, 0.0f, 1.0f);
    if (t.filter_kind == FILTER_NEAREST) return texel_at(scene, t, int(floor(x)), int(floor(y)));
    x -= 0.5f;
    y -= 0.5f;
    int i = int(floor(x));
    int j = int(floor(y));
    float a = x - float(i);
    float b = y - float(j);
    vec4 top = mix(texel_at(scene, t, i, j), texel_at(scene, t, i + 1, j), a);
    vec4 bottom = mix(texel_at(scene, t, i, j + 1), texel_at(scene, t, i + 1, j + 1), a);
    return mix(top, bottom, b);
}

KERNELS_END
#endif
