# spinel_flags: how every target of this project is compiled. An interface target, so that nothing leaks to projects
# that include this one.
#
# Floating point: -fno-math-errno and -fno-trapping-math change no result, they only drop errno and the trap order, so
# that sqrt, floor and comparisons become single vector instructions. -ffast-math is never used: ray tracing relies on
# infinities (slab tests) and on NaN failing comparisons.
add_library(spinel_flags INTERFACE)
target_compile_features(spinel_flags INTERFACE cxx_std_20)
target_compile_options(spinel_flags INTERFACE -Wall -Wextra -fno-math-errno -fno-trapping-math)
# g++ 12 warns of overlapping copies inside std::string's operator+, where there are none (GCC bug 105329).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(spinel_flags INTERFACE -Wno-restrict)
endif()
if(SPINEL_ARCH)
    target_compile_options(spinel_flags INTERFACE "-march=${SPINEL_ARCH}")
endif()

if(PROJECT_IS_TOP_LEVEL)
    set(CMAKE_CXX_EXTENSIONS OFF)
    set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
    if(NOT CMAKE_BUILD_TYPE)
        set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug or RelWithDebInfo" FORCE)
    endif()
    find_program(CCACHE ccache)
    if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
        set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE}")
    endif()
endif()

# Sanitizers apply to everything that is linked together, tests and libraries alike.
set(SPINEL_SANITIZE "" CACHE STRING "Value for -fsanitize: address,undefined or thread (empty: none)")
if(SPINEL_SANITIZE)
    target_compile_options(spinel_flags INTERFACE "-fsanitize=${SPINEL_SANITIZE}" -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(spinel_flags INTERFACE "-fsanitize=${SPINEL_SANITIZE}")
endif()
