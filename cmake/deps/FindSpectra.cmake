# Eigenvalue solvers (header only): target Spectra::Spectra.
find_path(Spectra_INCLUDE_DIR Spectra/SymEigsSolver.h)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Spectra REQUIRED_VARS Spectra_INCLUDE_DIR)
if(Spectra_FOUND AND NOT TARGET Spectra::Spectra)
  add_library(Spectra::Spectra INTERFACE IMPORTED)
  target_include_directories(Spectra::Spectra INTERFACE ${Spectra_INCLUDE_DIR})
  target_link_libraries(Spectra::Spectra INTERFACE Eigen3::Eigen)
endif()
