# add_layer(<folder> SOURCES a.f90 ... USES <layers and libraries>)
# add_layer(<folder> PARTS <parts>)
#
# One static library and one module directory per folder of src. A layer sees only the module
# directories of what it USES, so that a forbidden `use` does not compile. A layer of PARTS has one library and one module
# directory for each of them; who uses the layer sees them all.
function(add_layer name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PARTS;USES" ${ARGN})
  if(ARG_PARTS)
    list(TRANSFORM ARG_PARTS PREPEND flusi_${name}_)
    add_library(flusi_${name} INTERFACE)
    target_link_libraries(flusi_${name} INTERFACE ${ARG_PARTS} ${ARG_USES})
  else()
    add_module_library(flusi_${name} ${name} SOURCES ${ARG_SOURCES} USES ${ARG_USES})
  endif()
endfunction()

# add_part(<layer> <part> SOURCES a.f90 ... USES flusi_<layer>_<part> ... <layers and libraries>)
#
# A part of a layer: one of its folders, or several that need each other. `root` is what stands in the folder of the layer itself.
# A part sees only those parts of its layer that it USES.
function(add_part layer part)
  add_module_library(flusi_${layer}_${part} ${layer}/${part} ${ARGN})
endfunction()

# add_module_library(<target> <module directory> SOURCES ... USES ...): what add_layer and add_part make.
function(add_module_library target folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
  add_library(${target} STATIC ${ARG_SOURCES})
  set(moddir ${CMAKE_BINARY_DIR}/modules/${folder})
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
