# `cmake --install` and, from another project, find_package(tremula): tremula::tremula is the whole library.
include(CMakePackageConfigHelpers)

get_property(components GLOBAL PROPERTY TREMULA_COMPONENTS)
install(TARGETS ${components} EXPORT tremulaTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
include(TremulaPublicHeaders)
foreach(header ${public_headers})
  get_filename_component(folder tremula/${header} DIRECTORY)
  install(FILES src/tremula/${header}.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
endforeach()
install(EXPORT tremulaTargets NAMESPACE tremula:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tremula)
list(TRANSFORM components REPLACE "^tremula_" "" OUTPUT_VARIABLE component_names)
list(JOIN component_names ", " component_names)
configure_package_config_file(cmake/tremulaConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/tremulaConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tremula)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/tremulaConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/tremulaConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/tremulaConfigVersion.cmake
              cmake/deps/FindFFT.cmake cmake/deps/FindRandom123.cmake
              cmake/deps/FindStb.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tremula)
if(TARGET tremula_cli)
  set_target_properties(tremula_cli PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
  install(TARGETS tremula_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
