# P3DFFT, which comes without a package file: libp3dfft and the Fortran module p3dfft under P3DFFT_ROOT, a variable of CMake
# or of the environment. Sets P3DFFT_FOUND and makes the target P3DFFT::P3DFFT. MPI and FFTW3 must have been found.
find_path(P3DFFT_INCLUDE_DIR p3dfft.mod PATH_SUFFIXES include include/p3dfft modules)
find_library(P3DFFT_LIBRARY p3dfft)
mark_as_advanced(P3DFFT_INCLUDE_DIR P3DFFT_LIBRARY)

# A module of another compiler, of single precision or of another MPI shows here, not in the middle of the build.
unset(P3DFFT_WORKS CACHE)
if(P3DFFT_INCLUDE_DIR AND P3DFFT_LIBRARY)
  include(CheckSourceCompiles)
  set(CMAKE_REQUIRED_QUIET ON)
  set(CMAKE_REQUIRED_INCLUDES ${P3DFFT_INCLUDE_DIR})
  set(CMAKE_REQUIRED_LIBRARIES ${P3DFFT_LIBRARY} PkgConfig::FFTW3 MPI::MPI_Fortran)
  check_source_compiles(Fortran "
    program probe
      use p3dfft, only: p3dfft_btran_c2r, p3dfft_clean, p3dfft_ftran_r2c, p3dfft_get_dims, p3dfft_setup, proc_dims
      implicit none
      complex(kind(1d0)) :: modes(4, 4, 3)
      double precision :: points(4, 4, 4)
      integer :: first(3), last(3), extent(3)
      if (allocated(proc_dims)) stop 1
      call p3dfft_setup([1, 1], 4, 4, 4, 0, overwrite=.true.)
      call p3dfft_get_dims(first, last, extent, 2)
      call p3dfft_ftran_r2c(points, modes, 'fft')
      call p3dfft_btran_c2r(modes, points, 'tff')
      call p3dfft_clean()
    end program probe" P3DFFT_WORKS)
  unset(CMAKE_REQUIRED_QUIET)
  unset(CMAKE_REQUIRED_INCLUDES)
  unset(CMAKE_REQUIRED_LIBRARIES)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(P3DFFT REQUIRED_VARS P3DFFT_LIBRARY P3DFFT_INCLUDE_DIR P3DFFT_WORKS
  REASON_FAILURE_MESSAGE "if library and p3dfft.mod were found but P3DFFT_WORKS is not set, a small program with them \
did not compile: see CMakeFiles/CMakeConfigureLog.yaml or CMakeError.log in the build folder")
if(P3DFFT_FOUND AND NOT TARGET P3DFFT::P3DFFT)
  add_library(P3DFFT::P3DFFT UNKNOWN IMPORTED)
  set_target_properties(P3DFFT::P3DFFT PROPERTIES IMPORTED_LOCATION ${P3DFFT_LIBRARY})
  target_include_directories(P3DFFT::P3DFFT INTERFACE ${P3DFFT_INCLUDE_DIR})
  target_link_libraries(P3DFFT::P3DFFT INTERFACE PkgConfig::FFTW3 MPI::MPI_Fortran)
endif()
