# One flag per line with its reason. Other compilers than GNU get their own defaults.
if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  set(FLUSI_WARNINGS
      -std=f2008              # the language we promise
      -Wall
      -Wextra
      -Wimplicit-interface    # every call is checked
      -Wimplicit-procedure
      -Wuse-without-only      # a reader must see where a name comes from
      -Wno-function-elimination # short-circuit is not promised by the language, and not relied on
      -Wno-maybe-uninitialized # false positives on allocatable descriptors at -O2 and above
      $<$<CONFIG:Release>:-Wno-uninitialized> # the same false positives, at -O3 only
      -fimplicit-none)
  # Plain variables: CMake has already put empty cache entries for build types it does not know.
  # No -ffast-math: NaN checks must work and results must not depend on the vector width of a loop.
  set(CMAKE_Fortran_FLAGS_RELEASE "-O3 -fno-math-errno -fno-trapping-math")
  set(CMAKE_Fortran_FLAGS_DEV
      "-Og -g -fbacktrace -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -finit-real=snan")
  set(CMAKE_Fortran_FLAGS_SANITIZE
      "-O1 -g -fbacktrace -fsanitize=address,undefined -fno-omit-frame-pointer")
  set(CMAKE_EXE_LINKER_FLAGS_SANITIZE "-fsanitize=address,undefined")
  # The source of a unit test runs for moments, and the compiler for half as long. What it tests has the flags of all.
  set(FLUSI_UNIT_FLAGS $<$<CONFIG:Release>:-O1>)
  if(FLUSI_NATIVE)
    add_compile_options(-march=native)
  endif()
endif()
