# What --version prints: commit, compiler and flags, compiled into base_build.
execute_process(COMMAND git describe --always --dirty --abbrev=12
  WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE FLUSI_GIT_COMMIT
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE git_failed)
if(git_failed OR NOT FLUSI_GIT_COMMIT)
  set(FLUSI_GIT_COMMIT "unknown")
endif()
# A new commit makes CMake configure again, so that the compiled-in commit stays true.
if(EXISTS ${CMAKE_SOURCE_DIR}/.git/logs/HEAD)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/.git/logs/HEAD)
endif()
string(TOUPPER "${CMAKE_BUILD_TYPE}" _type)
get_directory_property(_options COMPILE_OPTIONS)
string(REPLACE ";" " " _options "${_options}")
string(STRIP "${CMAKE_Fortran_FLAGS} ${CMAKE_Fortran_FLAGS_${_type}} ${_options}" FLUSI_FLAGS)
configure_file(${CMAKE_SOURCE_DIR}/src/base/base_build.f90.in
               ${CMAKE_BINARY_DIR}/generated/base_build.f90 @ONLY)
