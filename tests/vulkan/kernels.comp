#version 460
#extension GL_GOOGLE_include_directive : require
// Every kernel in one shader. It computes nothing: compiling it proves that all of src/kernels is GLSL as well as C++,
// and that no two headers define the same name.
#include "all_kernels.h"
layout(local_size_x = 1) in;
void main() {}
