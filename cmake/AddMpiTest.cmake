# The one place that knows how tests are started: rank counts, oversubscription, containers.
set(FLUSI_TEST_ENVIRONMENT
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    OMPI_MCA_rmaps_base_oversubscribe=1
    OMPI_MCA_hwloc_base_binding_policy=none   # tests that run side by side must not share one core
    OMPI_MCA_mpi_yield_when_idle=1            # more ranks than cores must not starve each other
    OMPI_MCA_btl_vader_single_copy_mechanism=none  # containers forbid ptrace-like copies
    # Open MPI 5 starts ranks by PRRTE and has other names for these; each version ignores those of the other.
    PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
    PRTE_MCA_hwloc_default_binding_policy=none
    OMPI_MCA_smsc=^cma
    # Ranks share a machine. What Open MPI 5 says of its network disturbs tests, and each start of ranks that looks for
    # networks takes up to two seconds.
    OMPI_MCA_pml=ob1 OMPI_MCA_btl=^tcp,ofi,openib
    OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1)
string(REPLACE ";" "\n" FLUSI_TEST_ENVIRONMENT_LINES "${FLUSI_TEST_ENVIRONMENT}")
file(WRITE ${CMAKE_BINARY_DIR}/test_environment "${FLUSI_TEST_ENVIRONMENT_LINES}\n")

# Seconds after which a test is taken for dead: on a machine that does much else it may take a hundred times as long as alone.
set(FLUSI_TEST_ALIVE 1200)

# add_mpi_test(<name> SOURCES t.f90 USES <layers> [RANKS 1 2 3 4] LABEL unit|verification|regression
#              [TIMEOUT s] [COST s] [ARGS ...])
# With RANKS the test runs once under mpirun for every count; without, it runs as a plain process. COST: seconds on a quiet
# machine, given where there are many of them, so that what takes long begins early in the first run of a build, too.
# Ranks of so short tests wait for their start and for each other: two of them count as one processor, so that not all tests
# of many ranks are left for the end, where few of them fit beside each other.
function(add_mpi_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT;COST" "SOURCES;USES;RANKS;ARGS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests/bin
    Fortran_MODULE_DIRECTORY ${CMAKE_BINARY_DIR}/modules/tests/${name})
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:Fortran>:${FLUSI_WARNINGS}>)
  if(ARG_LABEL STREQUAL unit)
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:Fortran>:${FLUSI_UNIT_FLAGS}>)
  endif()
  target_link_libraries(${name} PRIVATE flusi_testkit ${ARG_USES})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT ${FLUSI_TEST_ALIVE})
  endif()
  if(NOT ARG_COST)
    set(ARG_COST 0)
  endif()
  if(ARG_RANKS)
    foreach(ranks ${ARG_RANKS})
      math(EXPR processors "(${ranks} + 1) / 2")
      set(workdir ${CMAKE_BINARY_DIR}/tests/runs/${name}_${ranks})
      file(MAKE_DIRECTORY ${workdir})
      add_test(NAME ${name}_${ranks}
        COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} ${MPIEXEC_PREFLAGS}
                $<TARGET_FILE:${name}> ${ARG_ARGS}
        WORKING_DIRECTORY ${workdir})
      set_tests_properties(${name}_${ranks} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
        ENVIRONMENT "${FLUSI_TEST_ENVIRONMENT}" PROCESSORS ${processors} COST ${ARG_COST})
    endforeach()
  else()
    set(workdir ${CMAKE_BINARY_DIR}/tests/runs/${name})
    file(MAKE_DIRECTORY ${workdir})
    add_test(NAME ${name} COMMAND ${name} ${ARG_ARGS} WORKING_DIRECTORY ${workdir})
    set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
      ENVIRONMENT "${FLUSI_TEST_ENVIRONMENT}" COST ${ARG_COST})
  endif()
endfunction()

# add_p3dfft_test(<name> RANKS ... LABEL l [TIMEOUT s]): the test <name> of add_mpi_test once more, with the transform of
# P3DFFT, if there is one.
function(add_p3dfft_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "RANKS" ${ARGN})
  if(NOT P3DFFT_FOUND)
    return()
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT ${FLUSI_TEST_ALIVE})
  endif()
  foreach(ranks ${ARG_RANKS})
    math(EXPR processors "(${ranks} + 1) / 2")
    set(workdir ${CMAKE_BINARY_DIR}/tests/runs/${name}_p3dfft_${ranks})
    file(MAKE_DIRECTORY ${workdir})
    add_test(NAME ${name}_p3dfft_${ranks}
      COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} ${MPIEXEC_PREFLAGS} $<TARGET_FILE:${name}> p3dfft
      WORKING_DIRECTORY ${workdir})
    set_tests_properties(${name}_p3dfft_${ranks} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
      ENVIRONMENT "${FLUSI_TEST_ENVIRONMENT}" PROCESSORS ${processors})
  endforeach()
endfunction()

# add_script_test(<name> LABEL l COMMAND ... [TIMEOUT s] [PROCESSORS n] [COST s]): whole-program tests
# driven by a script; they get the same environment and a working directory of their own. PROCESSORS: what they keep busy on
# average. It is 1 for scripts that start short runs of two ranks: these wait for their start, for each other and for what
# looks at their files.
set(FLUSI_PYTHONPATH "${CMAKE_SOURCE_DIR}/tools:${CMAKE_SOURCE_DIR}/tests/support:${CMAKE_SOURCE_DIR}/tests/verification:${CMAKE_SOURCE_DIR}/bench/scaling:${CMAKE_SOURCE_DIR}/bench/common")
function(add_script_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT;PROCESSORS;COST" "COMMAND" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT ${FLUSI_TEST_ALIVE})
  endif()
  if(NOT ARG_PROCESSORS)
    set(ARG_PROCESSORS 1)
  endif()
  if(NOT ARG_COST)
    set(ARG_COST 0)
  endif()
  set(workdir ${CMAKE_BINARY_DIR}/tests/runs/${name})
  file(MAKE_DIRECTORY ${workdir})
  add_test(NAME ${name} COMMAND ${ARG_COMMAND} WORKING_DIRECTORY ${workdir})
  set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
    PROCESSORS ${ARG_PROCESSORS} COST ${ARG_COST} ENVIRONMENT "${FLUSI_TEST_ENVIRONMENT};MPIEXEC=${MPIEXEC_EXECUTABLE};PYTHONPATH=${FLUSI_PYTHONPATH}")
endfunction()
