# spinel_unity(<target> <room> <batches> <source>...): compiles these sources of the target in so many batches. Most of
# the time of a source that computes little goes into what it includes: reading it, and code of the same inline functions
# and templates again and again. Together, eight sources take a third to a half of it.
#
# For options, readers of scenes and tests: never for what is measured, whose inlining should not hang on its neighbours.
# Unnamed namespaces of src/ are shared within a batch, so a file's own names tell its subject; tests stand in a namespace
# per file. Which batch a source is in hangs on its name alone, so that a new one changes no other batch.
# -DSPINEL_UNITY=OFF compiles every source alone: quicker after a change in one of them, and what clang-tidy asks for.
option(SPINEL_UNITY "Compile cold sources and tests in batches: a full build takes two thirds of the time" ON)

function(spinel_unity target room batches)
    if(NOT SPINEL_UNITY)
        return()
    endif()
    foreach(source IN LISTS ARGN)
        cmake_path(GET source FILENAME name)
        string(MD5 hash "${name}")
        string(SUBSTRING "${hash}" 0 6 digits)
        math(EXPR batch "0x${digits} % ${batches}")
        set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "${room}_${batch}")
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
