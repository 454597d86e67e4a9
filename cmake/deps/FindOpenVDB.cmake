# Volumes: target OpenVDB::openvdb. Its headers include those of Boost, Imath and TBB.
find_path(OpenVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(OpenVDB_LIBRARY openvdb)
find_path(OpenVDB_BOOST_DIR boost/uuid/uuid.hpp)
find_path(OpenVDB_IMATH_DIR half.h PATH_SUFFIXES Imath)
find_library(OpenVDB_IMATH NAMES Imath Imath-3_1 Imath-3_2)
find_package(TBB QUIET)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVDB REQUIRED_VARS OpenVDB_LIBRARY OpenVDB_INCLUDE_DIR OpenVDB_BOOST_DIR
                                  OpenVDB_IMATH_DIR OpenVDB_IMATH TBB_FOUND)
if(OpenVDB_FOUND AND NOT TARGET OpenVDB::openvdb)
  add_library(OpenVDB::openvdb UNKNOWN IMPORTED GLOBAL)
  set_target_properties(OpenVDB::openvdb PROPERTIES IMPORTED_LOCATION ${OpenVDB_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES "${OpenVDB_INCLUDE_DIR};${OpenVDB_BOOST_DIR};${OpenVDB_IMATH_DIR}"
                        INTERFACE_LINK_LIBRARIES "${OpenVDB_IMATH};TBB::tbb")
endif()
