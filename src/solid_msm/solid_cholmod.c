/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The few CHOLMOD calls that solid_cholesky needs, behind an opaque handle. Fortran cannot name the
 * members of cholmod_common, which are needed to choose the method. */
#define _GNU_SOURCE /* RTLD_DEFAULT */
#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  cholmod_common common;
  cholmod_sparse pattern; /* borrows the arrays below */
  cholmod_factor *factor;
  cholmod_dense *x, *y, *e;
  int n;
} solver_t;

/* CHOLMOD's supernodal loops ask for four threads whatever OMP_NUM_THREADS says. A wing is far too
 * small for that, and several ranks share a node: no parallel regions below this level. */
static int one_thread(void) {
  int levels = omp_get_max_active_levels();
  omp_set_max_active_levels(0);
  return levels;
}

/* Address of an exported function, NULL if this BLAS has none of the name. */
static void *blas_function(const char *name) { return dlsym(RTLD_DEFAULT, name); }

/* OpenBLAS has threads of its own, which wait in a loop for their share of blocks of a few rows: ten times
 * slower where the cores are busy with other ranks. Another BLAS does not know the name. */
static void one_blas_thread(void) {
  void (*set_threads)(int);
  void *found = blas_function("openblas_set_num_threads");
  if (!found) return;
  memcpy(&set_threads, &found, sizeof set_threads); /* ISO C has no conversion from object to function */
  set_threads(1);
}

/* An OpenBLAS older than the processor does not know it and takes kernels of 2004 ("Prescott"), which cost a wing
 * a third of its speed. It looks at OPENBLAS_CORETYPE when it starts only, so it starts again, with kernels that
 * this processor can run; a user's own choice stays. */
static void known_blas_kernels(void) {
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

void solid_cholmod_free(solver_t **handle) {
  solver_t *s = *handle;
  if (!s) return;
  cholmod_free_factor(&s->factor, &s->common);
  cholmod_free_dense(&s->x, &s->common);
  cholmod_free_dense(&s->y, &s->common);
  cholmod_free_dense(&s->e, &s->common);
  cholmod_finish(&s->common);
  free(s);
  *handle = NULL;
}

/* Upper triangle by columns, 0-based, rows sorted; colptr and rowind must outlive the handle.
 * mode 0: CHOLMOD's choice of simplicial or supernodal, 1: simplicial, 2: supernodal. */
int solid_cholmod_analyse(solver_t **handle, int n, int *colptr, int *rowind, int mode) {
  int levels = one_thread();
  known_blas_kernels();
  one_blas_thread();
  solver_t *s = calloc(1, sizeof *s);
  *handle = s;
  if (!s) return -1;
  cholmod_start(&s->common);
  s->n = n;
  s->common.print = 0;
  s->common.supernodal = mode == 1 ? CHOLMOD_SIMPLICIAL : mode == 2 ? CHOLMOD_SUPERNODAL : CHOLMOD_AUTO;
  s->common.nmethods = 1;
  s->common.method[0].ordering = CHOLMOD_AMD;
  s->common.quick_return_if_not_posdef = 1;
  s->common.final_ll = 1;
  s->pattern.nrow = s->pattern.ncol = (size_t)n;
  s->pattern.nzmax = (size_t)colptr[n];
  s->pattern.p = colptr;
  s->pattern.i = rowind;
  s->pattern.stype = 1;
  s->pattern.itype = CHOLMOD_INT;
  s->pattern.xtype = CHOLMOD_PATTERN;
  s->pattern.dtype = CHOLMOD_DOUBLE;
  s->pattern.sorted = 1;
  s->pattern.packed = 1;
  s->factor = cholmod_analyze(&s->pattern, &s->common);
  omp_set_max_active_levels(levels);
  return s->factor ? 0 : -1;
}

/* 0: factorised; 1: not positive definite; -1: out of memory or worse. */
int solid_cholmod_factorise(solver_t *s, double *values) {
  int levels = one_thread();
  cholmod_sparse a = s->pattern;
  a.x = values;
  a.xtype = CHOLMOD_REAL;
  s->common.status = CHOLMOD_OK;
  int ok = cholmod_factorize(&a, s->factor, &s->common);
  omp_set_max_active_levels(levels);
  if (!ok || s->common.status < 0) return -1;
  return s->common.status == CHOLMOD_NOT_POSDEF || s->factor->minor < (size_t)s->n ? 1 : 0;
}

/* b(n, columns) is replaced by the solution. 0: done. */
int solid_cholmod_solve(solver_t *s, int columns, double *b) {
  int levels = one_thread();
  cholmod_dense rhs = {0};
  rhs.nrow = rhs.d = (size_t)s->n;
  rhs.ncol = (size_t)columns;
  rhs.nzmax = rhs.nrow*rhs.ncol;
  rhs.x = b;
  rhs.xtype = CHOLMOD_REAL;
  rhs.dtype = CHOLMOD_DOUBLE;
  int ok = cholmod_solve2(CHOLMOD_A, s->factor, &rhs, NULL, &s->x, NULL, &s->y, &s->e, &s->common);
  omp_set_max_active_levels(levels);
  if (!ok) return -1;
  memcpy(b, s->x->x, rhs.nzmax*sizeof *b);
  return 0;
}

/* (smallest/largest diagonal of L)^2, a cheap estimate of 1/condition. */
double solid_cholmod_rcond(solver_t *s) { return cholmod_rcond(s->factor, &s->common); }

/* Entries of the factor. */
double solid_cholmod_fill(solver_t *s) { return s->common.lnz; }
