# spinel_unity(<target> <source>...): compiles these sources of the target in batches. Most of the time of a source that
# computes little goes into what it includes: reading it, and code of the same inline functions and templates again and
# again. Together they take a third to a half of it.
#
# For options, readers of scenes and tests: never for what is measured, whose inlining should not hang on its neighbours.
# The names of a batch share its unnamed namespace; tests, which name things alike, stand in a namespace per file.
# -DSPINEL_UNITY=OFF compiles every source alone: quicker after a change in one of them, and what clang-tidy asks for.
option(SPINEL_UNITY "Compile cold sources and tests in batches: a full build takes two thirds of the time" ON)

function(spinel_unity target)
    if(NOT SPINEL_UNITY)
        return()
    endif()
    set(batch_size 8)
    set(at 0)
    foreach(source IN LISTS ARGN)
        math(EXPR batch "${at} / ${batch_size}")
        math(EXPR at "${at} + 1")
        set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "${target}_${batch}")
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
