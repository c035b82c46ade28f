# MPI (mpi_f08), FFTW3, parallel HDF5, LAPACK; every one of them is in Debian. P3DFFT is not, and need not be there.
find_package(MPI REQUIRED COMPONENTS C Fortran)
if(NOT MPI_Fortran_HAVE_F08_MODULE)
  message(FATAL_ERROR "This MPI has no Fortran 2008 module mpi_f08 for ${CMAKE_Fortran_COMPILER}")
endif()

find_package(PkgConfig REQUIRED)
pkg_check_modules(FFTW3 REQUIRED IMPORTED_TARGET fftw3)
find_path(FFTW3_FORTRAN_INCLUDE fftw3.f03 HINTS ${FFTW3_INCLUDE_DIRS} ${FFTW3_INCLUDEDIR} REQUIRED)

# A second transform. Whoever says where it is wants it; otherwise it may be anywhere or nowhere.
if(P3DFFT_ROOT OR DEFINED ENV{P3DFFT_ROOT})
  find_package(P3DFFT REQUIRED)
else()
  find_package(P3DFFT QUIET)
endif()

# Debian ships serial and parallel HDF5 side by side; only the parallel one will do.
set(HDF5_PREFER_PARALLEL ON)
find_package(HDF5 REQUIRED COMPONENTS Fortran)
if(NOT HDF5_IS_PARALLEL)
  message(FATAL_ERROR "HDF5 was found without MPI support; Debian: libhdf5-openmpi-dev")
endif()

find_package(LAPACK REQUIRED)

# Sparse Cholesky for the wing (Debian: libsuitesparse-dev), which has no package file for CMake.
# Its supernodal part lives from BLAS: libopenblas-serial-dev makes it several times faster.
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS C Fortran) # only to keep CHOLMOD from starting threads, and to test that
add_library(CHOLMOD::CHOLMOD INTERFACE IMPORTED)
target_include_directories(CHOLMOD::CHOLMOD INTERFACE ${CHOLMOD_INCLUDE_DIR})
target_link_libraries(CHOLMOD::CHOLMOD INTERFACE ${CHOLMOD_LIBRARY} OpenMP::OpenMP_C)
