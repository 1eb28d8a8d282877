# OpenVDB as the target SpinelOpenVDB. Its own finder asks for Boost and more, which no header that is used here needs.
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
mark_as_advanced(OPENVDB_INCLUDE_DIR OPENVDB_LIBRARY)
if(NOT TARGET SpinelOpenVDB)
    add_library(SpinelOpenVDB UNKNOWN IMPORTED)
    set_target_properties(SpinelOpenVDB PROPERTIES IMPORTED_LOCATION "${OPENVDB_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OPENVDB_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES TBB::tbb)
endif()
