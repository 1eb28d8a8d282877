#version 460
// to.at[i] = scale * from.at[i]: what a dispatch reads, writes and is told.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Words { uint at[]; };
layout(push_constant, scalar) uniform PushConstants {
    Words from;
    Words to;
    uint count;
    uint scale;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) to.at[i] = scale * from.at[i];
}
