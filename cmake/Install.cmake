# cmake --install: a tree that works without the source.
#
#   bin                    flusi, msm_train, msm_diagnose; flusi-<tool> for every command of tools
#   share/flusi-msm        ini, wings, tools (the Python package and its commands), slurm, modulefiles
#   share/doc/flusi-msm    README, documents, licence, citation
#   share/man/man1, share/bash-completion/completions     made of --help
#   lib/cmake/flusi-msm    find_package(flusi-msm): targets flusi-msm::flusi and the others
include(CMakePackageConfigHelpers)
set(share ${CMAKE_INSTALL_DATADIR}/flusi-msm)
set(doc ${CMAKE_INSTALL_DATADIR}/doc/flusi-msm)
set(programs flusi msm_train msm_diagnose)

install(DIRECTORY ini wings DESTINATION ${share} PATTERN "*.h5.part" EXCLUDE)
install(DIRECTORY tools/flusi_msm DESTINATION ${share}/tools PATTERN "__pycache__" EXCLUDE PATTERN "ruff.toml" EXCLUDE)
install(DIRECTORY tools/slurm/ DESTINATION ${share}/slurm)
install(FILES tools/pyproject.toml tools/requirements.txt tools/requirements-mesh.txt tools/requirements-render.txt
        DESTINATION ${share}/tools)
install(DIRECTORY docs/ DESTINATION ${doc}/docs PATTERN "*.py" EXCLUDE)
install(FILES README.md CHANGELOG.md CITATION.cff LICENSE DESTINATION ${doc})

# The commands: what tools holds that belongs to the package, under the names that pip gives them. The old name reproduce-paper would
# give the command of reproduce_paper again.
file(GLOB candidates CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tools/*)
set(wrappers ${CMAKE_BINARY_DIR}/generated/wrappers)
foreach(candidate ${candidates})
  get_filename_component(tool ${candidate} NAME)
  if(NOT IS_DIRECTORY ${candidate} AND NOT IS_SYMLINK ${candidate} AND NOT tool MATCHES "[.-]")
    file(STRINGS ${candidate} uses_package REGEX "^import flusi_msm" LIMIT_COUNT 1)
    if(uses_package)
      string(REPLACE "_" "-" command flusi-${tool})
      file(CONFIGURE OUTPUT ${wrappers}/${command} @ONLY CONTENT [=[#!/bin/sh
# Runs the tool @tool@ of flusi-msm.
tools=$(dirname "$(readlink -f "$0")")/../@share@/tools
exec "$tools/python" "$tools/@tool@" "$@"
]=])
      install(PROGRAMS ${wrappers}/${command} DESTINATION ${CMAKE_INSTALL_BINDIR})
      install(PROGRAMS ${candidate} DESTINATION ${share}/tools)
    endif()
  endif()
endforeach()
install(PROGRAMS tools/python DESTINATION ${share}/tools)

# Manual pages and completion need the programs to run on this machine; where they cannot, the tree is complete without.
install(CODE "set(programs ${programs})
set(bin \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
set(man \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1\")
set(completions \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/bash-completion/completions\")
set(awk \"${CMAKE_SOURCE_DIR}/cmake/help_to_man.awk\")
set(version ${PROJECT_VERSION})")
install(SCRIPT ${CMAKE_SOURCE_DIR}/cmake/InstallHelp.cmake)

file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/modulefile @ONLY CONTENT [=[#%Module1.0
# For Environment Modules and Lmod: module use PREFIX/share/flusi-msm/modulefiles; module load flusi-msm
proc ModulesHelp { } { puts stderr "flusi-msm @PROJECT_VERSION@: flow around insects with flexible wings" }
module-whatis "flusi-msm @PROJECT_VERSION@: flow around insects with flexible wings"
conflict flusi-msm
# Two folders above share/flusi-msm/modulefiles/flusi-msm.
set prefix [file normalize [file join [file dirname $ModulesCurrentModulefile] .. .. .. ..]]
prepend-path PATH "$prefix/@CMAKE_INSTALL_BINDIR@"
prepend-path MANPATH "$prefix/@CMAKE_INSTALL_MANDIR@"
prepend-path CMAKE_PREFIX_PATH "$prefix"
prepend-path PYTHONPATH "$prefix/@share@/tools"
setenv FLUSI_SHARE "$prefix/@share@"
# The compiler, MPI, FFTW, HDF5 and OpenBLAS of the build, for example:
# depends-on gcc openmpi fftw hdf5 openblas
]=])
install(FILES ${CMAKE_BINARY_DIR}/generated/modulefile DESTINATION ${share}/modulefiles/flusi-msm RENAME ${PROJECT_VERSION})

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/flusi-msm)
install(EXPORT flusi-msm-targets NAMESPACE flusi-msm:: DESTINATION ${package})
configure_package_config_file(cmake/flusi-msm-config.cmake.in ${CMAKE_BINARY_DIR}/generated/flusi-msm-config.cmake
                              INSTALL_DESTINATION ${package} PATH_VARS share)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/flusi-msm-config-version.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${CMAKE_BINARY_DIR}/generated/flusi-msm-config.cmake ${CMAKE_BINARY_DIR}/generated/flusi-msm-config-version.cmake
        DESTINATION ${package})
