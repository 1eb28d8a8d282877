# spinel_precompile(target header...): the headers from outside the project that nearly every source reads, and those
# given, are parsed once for the target. Never a header of the project: its change would rebuild everything, and g++
# warns of nothing that it reads this way.
#
# For g++ alone. `make lint` does without and takes every source alone (tools/clang-tidy.py, check_headers), so that one
# that forgets an include does not go unnoticed.
# What is in such a header is not free either: each source instantiates anew the templates that the header's inline
# functions use, wanted or not. Over a source without a line: JSON 0.4 s, GoogleTest 0.2 s, CLI11 4 s (1 s without
# optimising), all those below together 0.2 s. So GoogleTest is for tests alone, and the others stay with who reads them.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
set(intrinsics "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(intrinsics <immintrin.h>)  # kernels/portable.h reads them: 0.3 s
endif()

function(spinel_precompile target)
    target_precompile_headers(${target} PRIVATE
        <algorithm> <array> <bit> <charconv> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional>
        <limits> <map> <memory> <optional> <set> <span> <string> <string_view> <unordered_map> <utility> <variant> <vector>
        <fmt/format.h> <glm/glm.hpp> <glm/gtc/packing.hpp> ${intrinsics} ${ARGN})
endfunction()
