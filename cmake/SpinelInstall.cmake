# Installs the library with its package file, so that find_package(spinel) gives spinel::spinel. Public headers stand in
# include/spinel/; what they and the functions around them need of the rooms (plain records, results, the render loop)
# goes to include/spinel/rooms/ with its folders, and nothing else of src/ does.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(room_headers
    accel/bvh_builder.h
    core/huge_pages.h core/result.h
    geometry/mesh/mesh_structures.h
    devices/devices.h
    image/image_io.h image/pixels.h image/tone_map.h
    kernels/box.h kernels/bvh.h kernels/constants.h kernels/materials/description.h kernels/path_settings.h kernels/pixel_sample.h kernels/portable.h kernels/ray.h kernels/scene_view.h
    render/device.h render/film.h render/render.h
    scene/compiled_scene.h scene/material_registry.h)
foreach(header IN LISTS room_headers)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES "${PROJECT_SOURCE_DIR}/src/${header}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/spinel/rooms/${folder}")
endforeach()
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/spinel" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.h")

target_include_directories(spinel INTERFACE
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/spinel/rooms>")
target_compile_features(spinel PUBLIC cxx_std_20)
install(TARGETS spinel EXPORT spinelTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/spinel")
install(EXPORT spinelTargets NAMESPACE spinel:: DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/spinelConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_SOURCE_DIR}/cmake/spinelConfig.cmake" "${PROJECT_SOURCE_DIR}/cmake/SpinelOpenImageIO.cmake"
              "${PROJECT_SOURCE_DIR}/cmake/SpinelOpenVDB.cmake"
              "${PROJECT_BINARY_DIR}/spinelConfigVersion.cmake" DESTINATION "${package_dir}")
