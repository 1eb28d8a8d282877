# check_headers: compiles every header alone. One object per header, so that ninja and ccache redo only what changed;
# without optimisation no inline function is emitted, which makes this about as cheap as a syntax check.
# Not part of `all`; the test `structure: headers compile alone` builds it.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}"
     "${PROJECT_SOURCE_DIR}/src/*.h" "${PROJECT_SOURCE_DIR}/include/*.h")
set(header_sources "")
foreach(header IN LISTS headers)
    if((header MATCHES "^src/devices/vulkan/" AND NOT TARGET spinel_vulkan)
       OR (header MATCHES "^src/cli/" AND NOT TARGET spinel_cli))
        continue()
    endif()
    string(REGEX REPLACE "^(src|include)/" "" name "${header}")
    set(source "${PROJECT_BINARY_DIR}/check_headers/${name}.cpp")
    file(CONFIGURE OUTPUT "${source}" CONTENT "#include \"${name}\"\n" @ONLY)
    list(APPEND header_sources "${source}")
endforeach()

add_library(check_headers OBJECT EXCLUDE_FROM_ALL ${header_sources})
target_include_directories(check_headers PRIVATE "${PROJECT_SOURCE_DIR}/src" "${PROJECT_SOURCE_DIR}/include")
target_link_libraries(check_headers PRIVATE spinel spinel_flags OpenImageIO::OpenImageIO assimp::assimp
    $<TARGET_NAME_IF_EXISTS:spinel_vulkan> $<TARGET_NAME_IF_EXISTS:CLI11::CLI11>)
target_compile_options(check_headers PRIVATE -O0 -g0 -w)  # warnings belong to the sources that include them

add_test(NAME "structure: headers compile alone"
         COMMAND "${CMAKE_COMMAND}" --build "${PROJECT_BINARY_DIR}" --target check_headers --parallel 2)
