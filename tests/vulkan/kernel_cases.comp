#version 460
// One invocation answers one case of kernel_cases.h.
#include "kernel_cases.h"
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer CaseResults { CaseResult at[]; };
layout(push_constant, scalar) uniform PushConstants {
    CaseResults results;
    uint kind;
    uint count;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) results.at[i] = kernel_case(kind, i);
}
