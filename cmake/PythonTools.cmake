# Python for the tests: the environment made by tools/quickstart if there is one. FLUSI_PYTHON is any
# Python 3.9, FLUSI_PYTHON_TOOLS says whether it has what the plotting tools need, FLUSI_PYTHON_SCIPY
# whether it has scipy too, FLUSI_PYTHON_DRAWINGS whether it has pytest and reads drawings of wings, and FLUSI_PYTHON_PACKAGE
# whether it has what the package's tables and notebooks need.
if(NOT Python3_EXECUTABLE AND EXISTS ${CMAKE_SOURCE_DIR}/.venv/bin/python)
  set(Python3_EXECUTABLE ${CMAKE_SOURCE_DIR}/.venv/bin/python)
endif()
find_package(Python3 3.9 COMPONENTS Interpreter)
set(FLUSI_PYTHON_TOOLS FALSE)
set(FLUSI_PYTHON_SCIPY FALSE)
set(FLUSI_PYTHON_DRAWINGS FALSE)
set(FLUSI_PYTHON_PACKAGE FALSE)
if(Python3_Interpreter_FOUND)
  set(FLUSI_PYTHON ${Python3_EXECUTABLE})
  execute_process(COMMAND ${FLUSI_PYTHON} -c "import numpy, h5py, matplotlib"
    RESULT_VARIABLE import_failed OUTPUT_QUIET ERROR_QUIET)
  if(import_failed)
    message(STATUS "${FLUSI_PYTHON} lacks numpy, h5py or matplotlib: tests of the plotting tools are skipped "
                   "(tools/quickstart deps installs them)")
  else()
    set(FLUSI_PYTHON_TOOLS TRUE)
    execute_process(COMMAND ${FLUSI_PYTHON} -c "import scipy.sparse.linalg"
      RESULT_VARIABLE import_failed OUTPUT_QUIET ERROR_QUIET)
    if(import_failed)
      message(STATUS "${FLUSI_PYTHON} lacks scipy: tests of make_measurement are skipped "
                     "(tools/quickstart deps installs it)")
    else()
      set(FLUSI_PYTHON_SCIPY TRUE)
    endif()
    execute_process(COMMAND ${FLUSI_PYTHON} -c "import pytest, svgelements"
      RESULT_VARIABLE import_failed OUTPUT_QUIET ERROR_QUIET)
    if(import_failed)
      message(STATUS "${FLUSI_PYTHON} lacks pytest or svgelements: tests of wings from drawings are skipped "
                     "(tools/quickstart deps installs them)")
    else()
      set(FLUSI_PYTHON_DRAWINGS TRUE)
    endif()
    execute_process(COMMAND ${FLUSI_PYTHON} -c "import pytest, scipy, pandas, jsonschema, nbclient, ipykernel"
      RESULT_VARIABLE import_failed OUTPUT_QUIET ERROR_QUIET)
    if(import_failed)
      message(STATUS "${FLUSI_PYTHON} lacks pandas, jsonschema, nbclient or ipykernel: tests of the package flusi_msm are skipped "
                     "(tools/quickstart deps installs them)")
    else()
      set(FLUSI_PYTHON_PACKAGE TRUE)
    endif()
  endif()
else()
  message(STATUS "No Python 3.9 or newer: tests driven by Python are skipped")
endif()
