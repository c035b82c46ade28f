# add_layer(<folder> SOURCES a.f90 ... USES <layers and libraries>)
#
# One static library and one module directory per folder of src. A layer sees only the module
# directories of what it USES, so that a forbidden `use` does not compile.
function(add_layer name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
  set(target flusi_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  set(moddir ${CMAKE_BINARY_DIR}/modules/${name})
  set_target_properties(${target} PROPERTIES Fortran_MODULE_DIRECTORY ${moddir})
  target_include_directories(${target} INTERFACE ${moddir})
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:Fortran>:${FLUSI_WARNINGS}>)
  target_link_libraries(${target} PUBLIC ${ARG_USES})
endfunction()

# add_program(<name> SOURCES main.f90 USES <layers>): an executable that is installed.
function(add_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES Fortran_MODULE_DIRECTORY ${CMAKE_BINARY_DIR}/modules/${name})
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:Fortran>:${FLUSI_WARNINGS}>)
  target_link_libraries(${name} PRIVATE ${ARG_USES})
  install(TARGETS ${name} EXPORT flusi-msm-targets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
