# OpenVDB as the target SpinelOpenVDB. Its own finder asks for Boost and more, which no header that is used here needs.
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
# NanoVDB's headers, and blosc, by which its files may be packed.
find_path(NANOVDB_INCLUDE_DIR nanovdb/NanoVDB.h REQUIRED)
find_path(BLOSC_INCLUDE_DIR blosc.h REQUIRED)
find_library(BLOSC_LIBRARY blosc REQUIRED)
mark_as_advanced(OPENVDB_INCLUDE_DIR OPENVDB_LIBRARY NANOVDB_INCLUDE_DIR BLOSC_INCLUDE_DIR BLOSC_LIBRARY)
if(NOT TARGET SpinelNanoVDB)
    add_library(SpinelNanoVDB INTERFACE IMPORTED)
    set_target_properties(SpinelNanoVDB PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${NANOVDB_INCLUDE_DIR};${BLOSC_INCLUDE_DIR}"
        INTERFACE_LINK_LIBRARIES "${BLOSC_LIBRARY}")
endif()
if(NOT TARGET SpinelOpenVDB)
    add_library(SpinelOpenVDB UNKNOWN IMPORTED)
    set_target_properties(SpinelOpenVDB PROPERTIES IMPORTED_LOCATION "${OPENVDB_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OPENVDB_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES TBB::tbb)
endif()
