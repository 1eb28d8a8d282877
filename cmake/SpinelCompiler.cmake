# spinel_flags: how every target of this project is compiled. An interface target, so that nothing leaks to projects
# that include this one.
#
# Floating point: -fno-math-errno and -fno-trapping-math change no result, they only drop errno and the trap order, so
# that sqrt, floor and comparisons become single vector instructions. -ffast-math is never used: ray tracing relies on
# infinities (slab tests) and on NaN failing comparisons.
add_library(spinel_flags INTERFACE)
target_compile_features(spinel_flags INTERFACE cxx_std_20)
target_compile_options(spinel_flags INTERFACE -Wall -Wextra -fno-math-errno -fno-trapping-math)
# As src/kernels/portable.h asks for, also where GLM is read before it.
target_compile_definitions(spinel_flags INTERFACE GLM_FORCE_XYZW_ONLY GLM_FORCE_INLINE)
# g++ 12 warns of overlapping and endless copies inside std::string, where there are none (GCC bugs 105329 and 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(spinel_flags INTERFACE -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds)
endif()
if(SPINEL_ARCH)
    target_compile_options(spinel_flags INTERFACE "-march=${SPINEL_ARCH}")
endif()

# spinel_cold, besides spinel_flags: code that is not worth the time to optimise it, such as options and checks. It more
# than halves the time to compile a test, most of which is what the macros of GoogleTest expand to. It wants precompiled
# headers of its own: g++ refuses those of optimised code.
add_library(spinel_cold INTERFACE)
target_compile_options(spinel_cold INTERFACE "$<$<CONFIG:Release>:-O0>")

if(PROJECT_IS_TOP_LEVEL)
    set(CMAKE_CXX_EXTENSIONS OFF)
    set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # g++ collects its garbage from 512 MB on only: a twentieth of its time
        add_compile_options(--param=ggc-min-heapsize=524288)
    endif()
    if(NOT CMAKE_BUILD_TYPE)
        set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug or RelWithDebInfo" FORCE)
    endif()
    find_program(CCACHE ccache)
    if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
        # What ccache wants to be told where headers are precompiled.
        set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env CCACHE_SLOPPINESS=pch_defines,time_macros "${CCACHE}")
    endif()
endif()

# Sanitizers apply to everything that is linked together, tests and libraries alike.
set(SPINEL_SANITIZE "" CACHE STRING "Value for -fsanitize: address,undefined or thread (empty: none)")
if(SPINEL_SANITIZE)
    target_compile_options(spinel_flags INTERFACE "-fsanitize=${SPINEL_SANITIZE}" -fno-sanitize-recover=all -fno-omit-frame-pointer)
    # g++ 12 checks the bounds of vectors' lanes by numbers that it has not set yet, and computes wrongly.
    if(SPINEL_SANITIZE MATCHES "undefined" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
        target_compile_options(spinel_flags INTERFACE -fno-sanitize=bounds)
    endif()
    target_link_options(spinel_flags INTERFACE "-fsanitize=${SPINEL_SANITIZE}")
endif()
