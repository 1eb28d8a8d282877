#pragma once
// What is compiled for AVX2 whatever the rest of the program is compiled for, and chosen when the program runs. Between
// SPINEL_AVX2_BEGIN and SPINEL_AVX2_END the compiler may use these instructions; functions from headers, which other
// files share, stay as they are. Only what has_avx2() allows may be called. SPINEL_AVX2_AS_ELSEWHERE_BEGIN is for what
// has to round as kernels do in the same build: multiplications and additions are fused only if they are there.

#if defined(__x86_64__) || defined(_M_X64)

#include <immintrin.h>

#define SPINEL_AVX2 1
#ifdef __clang__
#define SPINEL_AVX2_BEGIN \
    _Pragma("clang attribute push(__attribute__((target(\"avx2,fma,bmi,bmi2,popcnt\"))), apply_to = function)")
#define SPINEL_AVX2_AS_ELSEWHERE_BEGIN \
    _Pragma("clang attribute push(__attribute__((target(\"avx2,bmi,bmi2,popcnt\"))), apply_to = function)")
#define SPINEL_AVX2_END _Pragma("clang attribute pop")
#else
#define SPINEL_AVX2_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2,fma,bmi,bmi2,popcnt\")")
#define SPINEL_AVX2_AS_ELSEWHERE_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2,bmi,bmi2,popcnt\")")
#define SPINEL_AVX2_END _Pragma("GCC pop_options")
#endif

namespace spinel {

inline bool has_avx2() {
#if defined(__AVX2__) && defined(__FMA__) && defined(__BMI2__)
    return true;
#else
    static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                            __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    return has;
#endif
}

}  // namespace spinel

#endif
