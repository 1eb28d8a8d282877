# OpenImageIO by its own package file, made usable without OpenCV: Debian's lists /usr/include/opencv4 although only
# one optional header needs it, and CMake refuses a target with a missing include directory. The message level hides
# a long note of its dependency Imath on Python bindings that are not installed.
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(OpenImageIO REQUIRED)
unset(CMAKE_MESSAGE_LOG_LEVEL)
get_target_property(include_directories OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
set(existing "")
foreach(directory IN LISTS include_directories)
    if(EXISTS "${directory}")
        list(APPEND existing "${directory}")
    endif()
endforeach()
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${existing}")
