/* SPDX-License-Identifier: GPL-3.0-or-later
 * Sets up OpenBLAS. Another BLAS does not know these names and stays as it is. See base_blas.f90. */
#define _GNU_SOURCE /* RTLD_DEFAULT */
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* Address of an exported function, NULL if this BLAS has none of the name. */
static void *blas_function(const char *name) { return dlsym(RTLD_DEFAULT, name); }

/* The threads of OpenBLAS wait in a loop for their share of blocks of a few rows: ten times slower where the cores are busy with
 * other ranks. */
static void one_thread(void) {
  void (*set_threads)(int);
  void *found = blas_function("openblas_set_num_threads");
  if (!found) return;
  memcpy(&set_threads, &found, sizeof set_threads); /* ISO C has no conversion from object to function */
  set_threads(1);
}

/* An OpenBLAS older than the processor does not know it and takes kernels of 2004 ("Prescott"), which cost a wing
 * a third of its speed. It looks at OPENBLAS_CORETYPE when it starts only, so it starts again, with kernels that
 * this processor can run; a user's own choice stays. */
static void known_kernels(void) {
#if defined(__x86_64__) && defined(__GNUC__)
  char *(*core_name)(void);
  void (*quit)(void), (*start)(void);
  void *f_name = blas_function("openblas_get_corename");
  void *f_quit = blas_function("gotoblas_dynamic_quit"), *f_start = blas_function("gotoblas_dynamic_init");
  if (!f_name || !f_quit || !f_start || getenv("OPENBLAS_CORETYPE")) return;
  memcpy(&core_name, &f_name, sizeof core_name);
  memcpy(&quit, &f_quit, sizeof quit);
  memcpy(&start, &f_start, sizeof start);
  if (strcmp(core_name(), "Prescott") || !__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return;
  setenv("OPENBLAS_CORETYPE", "Haswell", 0);
  quit();
  start();
#endif
}

void flusi_prepare_blas(void) {
  static int is_prepared;
  if (is_prepared) return;
  is_prepared = 1;
  known_kernels();
  one_thread();
}
