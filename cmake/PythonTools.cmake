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

# Sets `variable` where FLUSI_PYTHON can import `modules`; otherwise says what is missing and which tests are skipped.
function(look_for_python variable modules missing skipped)
  execute_process(COMMAND ${FLUSI_PYTHON} -c "import ${modules}" RESULT_VARIABLE import_failed OUTPUT_QUIET ERROR_QUIET)
  if(import_failed)
    message(STATUS "${FLUSI_PYTHON} lacks ${missing}: ${skipped} are skipped (tools/quickstart deps installs what is missing)")
  else()
    set(${variable} TRUE PARENT_SCOPE)
  endif()
endfunction()

if(Python3_Interpreter_FOUND)
  set(FLUSI_PYTHON ${Python3_EXECUTABLE})
  look_for_python(FLUSI_PYTHON_TOOLS "numpy, h5py, matplotlib" "numpy, h5py or matplotlib" "tests of the plotting tools")
  if(FLUSI_PYTHON_TOOLS)
    look_for_python(FLUSI_PYTHON_SCIPY scipy.sparse.linalg scipy "tests of make_measurement")
    look_for_python(FLUSI_PYTHON_DRAWINGS "pytest, svgelements" "pytest or svgelements" "tests of wings from drawings")
    look_for_python(FLUSI_PYTHON_PACKAGE "pytest, scipy, pandas, jsonschema, nbclient, ipykernel"
                    "pandas, jsonschema, nbclient or ipykernel" "tests of the package flusi_msm")
  endif()
else()
  message(STATUS "No Python 3.9 or newer: tests driven by Python are skipped")
endif()
