#version 460
// One invocation answers one case of kernel_cases.h. A pipeline knows its kind of case beforehand, so that drivers
// compile no other.
#include "kernel_cases.h"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint KIND = 0u;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer CaseResults { CaseResult at[]; };
layout(push_constant, scalar) uniform PushConstants {
    CaseResults results;
    SceneViews scenes;
    uint count;
    uint unused;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    SceneView scene = scenes.at[0];
    microfacet_begin(scene);
    if (i < count) results.at[i] = kernel_case(scene, KIND, i);
}
