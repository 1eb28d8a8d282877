# spinel_compile_spirv(<variable> <source>): compiles a GLSL shader to SPIR-V in the build directory and appends the
# module's path to <variable>. Includes are found in src/ and in the build directory's shaders/; a changed header recompiles.
function(spinel_compile_spirv variable source)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE)
    cmake_path(GET source STEM name)
    set(module "${CMAKE_CURRENT_BINARY_DIR}/shaders/${name}.spv")
    add_custom_command(
        OUTPUT "${module}"
        COMMAND "${GLSLC}" --target-env=vulkan1.3 "-I${PROJECT_SOURCE_DIR}/src" "-I${CMAKE_CURRENT_BINARY_DIR}/shaders"
                -MD -MF "${module}.d" -MT "${module}" -o "${module}" "${source}"
        DEPENDS "${source}" DEPFILE "${module}.d"
        COMMENT "Compiling ${name}.comp to SPIR-V" VERBATIM)
    set(${variable} ${${variable}} "${module}" PARENT_SCOPE)
endfunction()
