# spinel_compile_spirv(<variable> <source> [KEEP_UNCALLED]): compiles a GLSL shader to SPIR-V in the build directory and
# appends the module's path to <variable>. Includes are found in src/ and in the build directory's shaders/; a changed
# header recompiles. KEEP_UNCALLED keeps functions that main does not reach, which glslc would drop before SPIR-V.
function(spinel_compile_spirv variable source)
    cmake_parse_arguments(PARSE_ARGV 2 argument "KEEP_UNCALLED" "" "")
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE)
    cmake_path(GET source STEM name)
    set(module "${CMAKE_CURRENT_BINARY_DIR}/shaders/${name}.spv")
    set(includes "-I${PROJECT_SOURCE_DIR}/src" "-I${CMAKE_CURRENT_BINARY_DIR}/shaders")
    if(argument_KEEP_UNCALLED)
        set(command "${GLSLANG}" --quiet --target-env vulkan1.3 --keep-uncalled ${includes} --depfile "${module}.d"
                    -o "${module}" "${source}")
    else()
        set(command "${GLSLC}" --target-env=vulkan1.3 ${includes} -MD -MF "${module}.d" -MT "${module}" -o "${module}" "${source}")
    endif()
    add_custom_command(OUTPUT "${module}" COMMAND ${command} DEPENDS "${source}" DEPFILE "${module}.d"
                       COMMENT "Compiling ${name}.comp to SPIR-V" VERBATIM)
    set(${variable} ${${variable}} "${module}" PARENT_SCOPE)
endfunction()
