/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The few CHOLMOD calls that solid_cholesky needs, behind an opaque handle. Fortran cannot name the
 * members of cholmod_common, which are needed to choose the method. */
#define _GNU_SOURCE /* RTLD_DEFAULT, RTLD_NEXT */
#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  cholmod_common common;
  cholmod_sparse *matrix; /* lower triangle, rows and columns in the order of elimination */
  int *order;             /* number of each row in the order of elimination, before it */
  int *place;             /* of every given value in the matrix */
  cholmod_factor *factor;
  cholmod_dense *rhs, *x, *y, *e; /* as wide as the widest right-hand side so far */
  int n;
} solver_t;

/* libgomp makes a team for every parallel region, for one thread too: it allocates, frees and calls the kernel to wake
 * nobody. CHOLMOD has hundreds of regions of a few rows in each factorisation, so that this costs a wing of 200 points a third
 * of the factorisation. This function stands before libgomp's for all that the program is linked with: a plain call while CHOLMOD
 * has one thread, and libgomp's for everybody else, also if CHOLMOD is called from a region, whose threads would share its loops.
 * CHOLMOD built with another OpenMP does not call it. */
static _Thread_local int is_alone;

typedef void parallel_t(void (*region)(void *), void *data, unsigned threads, unsigned flags);
parallel_t GOMP_parallel;

void GOMP_parallel(void (*region)(void *), void *data, unsigned threads, unsigned flags) {
  if (is_alone && omp_get_level() == 0) {
    region(data);
    return;
  }
  parallel_t *next;
  void *found = dlsym(RTLD_NEXT, "GOMP_parallel");
  if (!found) abort();
  memcpy(&next, &found, sizeof next); /* ISO C has no conversion from object to function */
  next(region, data, threads, flags);
}

/* CHOLMOD's supernodal loops ask for four threads whatever OMP_NUM_THREADS says. A wing is far too
 * small for that, and several ranks share a node: no parallel regions below this level. */
static int one_thread(void) {
  int levels = omp_get_max_active_levels();
  omp_set_max_active_levels(0);
  is_alone = 1;
  return levels;
}

static void end_one_thread(int levels) {
  is_alone = 0;
  omp_set_max_active_levels(levels);
}

/* Of base_blas.c: the setting that all of the process uses. */
void flusi_prepare_blas(void);

void solid_cholmod_free(solver_t **handle) {
  solver_t *s = *handle;
  if (!s) return;
  cholmod_free_factor(&s->factor, &s->common);
  cholmod_free_sparse(&s->matrix, &s->common);
  cholmod_free_dense(&s->rhs, &s->common);
  cholmod_free_dense(&s->x, &s->common);
  cholmod_free_dense(&s->y, &s->common);
  cholmod_free_dense(&s->e, &s->common);
  cholmod_finish(&s->common);
  free(s->order);
  free(s->place);
  free(s);
  *handle = NULL;
}

/* The order of elimination: AMD's, postordered. 0: found. */
static int find_order(solver_t *s, int n, int *colptr, int *rowind) {
  cholmod_sparse given = {0};
  given.nrow = given.ncol = (size_t)n;
  given.nzmax = (size_t)colptr[n];
  given.p = colptr;
  given.i = rowind;
  given.stype = 1;
  given.itype = CHOLMOD_INT;
  given.xtype = CHOLMOD_PATTERN;
  given.dtype = CHOLMOD_DOUBLE;
  given.sorted = 1;
  given.packed = 1;
  cholmod_factor *factor = cholmod_analyze(&given, &s->common);
  s->order = malloc((size_t)n*sizeof *s->order);
  if (factor && s->order) memcpy(s->order, factor->Perm, (size_t)n*sizeof *s->order);
  int found = factor && s->order;
  cholmod_free_factor(&factor, &s->common);
  return found ? 0 : -1;
}

/* The matrix in that order, its values to come, and the places where they go. 0: made. */
static int make_matrix(solver_t *s, int n, const int *colptr, const int *rowind) {
  size_t nnz = (size_t)colptr[n];
  int *new_number = malloc((size_t)n*sizeof *new_number), *next = calloc((size_t)n + 1, sizeof *next);
  s->place = malloc(nnz*sizeof *s->place);
  s->matrix = cholmod_allocate_sparse((size_t)n, (size_t)n, nnz, 0, 1, -1, CHOLMOD_REAL, &s->common);
  int made = new_number && next && s->place && s->matrix;
  if (made) {
    int *start = s->matrix->p, *row = s->matrix->i;
    for (int k = 0; k < n; k++) new_number[s->order[k]] = k;
    for (int j = 0; j < n; j++) {
      for (int k = colptr[j]; k < colptr[j + 1]; k++) {
        int a = new_number[rowind[k]], b = new_number[j];
        next[(a < b ? a : b) + 1]++;
      }
    }
    for (int j = 0; j < n; j++) next[j + 1] += next[j];
    memcpy(start, next, ((size_t)n + 1)*sizeof *start);
    for (int j = 0; j < n; j++) {
      for (int k = colptr[j]; k < colptr[j + 1]; k++) {
        int a = new_number[rowind[k]], b = new_number[j];
        s->place[k] = next[a < b ? a : b]++;
        row[s->place[k]] = a < b ? b : a;
      }
    }
  }
  free(new_number);
  free(next);
  return made ? 0 : -1;
}

/* Upper triangle by columns, 0-based, rows sorted.
 * mode 0: CHOLMOD's choice of simplicial or supernodal, 1: supernodal.
 * The matrix is kept in the order of elimination, lower triangle: CHOLMOD then takes it as it is, where otherwise it
 * makes a permuted copy for every factorisation. */
int solid_cholmod_analyse(solver_t **handle, int n, int *colptr, int *rowind, int mode) {
  int levels = one_thread();
  flusi_prepare_blas();
  solver_t *s = calloc(1, sizeof *s);
  *handle = s;
  if (!s) {
    end_one_thread(levels);
    return -1;
  }
  cholmod_start(&s->common);
  s->n = n;
  s->common.print = 0;
  s->common.supernodal = mode == 1 ? CHOLMOD_SUPERNODAL : CHOLMOD_AUTO;
  s->common.nmethods = 1;
  s->common.method[0].ordering = CHOLMOD_AMD;
  /* Larger supernodes than by default: a tenth faster for wings of 1000 points, although more zeros are computed. */
  s->common.zrelax[0] = 0.95;
  s->common.zrelax[1] = 0.4;
  s->common.zrelax[2] = 0.1;
  s->common.quick_return_if_not_posdef = 1;
  s->common.final_ll = 1;
  int status = find_order(s, n, colptr, rowind);
  if (!status) status = make_matrix(s, n, colptr, rowind);
  if (!status) {
    s->common.method[0].ordering = CHOLMOD_NATURAL;
    s->common.postorder = 0;
    s->factor = cholmod_analyze(s->matrix, &s->common);
    s->rhs = cholmod_allocate_dense((size_t)n, 1, (size_t)n, CHOLMOD_REAL, &s->common);
    if (!s->factor || !s->rhs) status = -1;
  }
  end_one_thread(levels);
  return status;
}

/* 0: factorised; 1: not positive definite; -1: out of memory or worse. */
int solid_cholmod_factorise(solver_t *s, const double *values) {
  int levels = one_thread();
  double *x = s->matrix->x;
  const int *start = s->matrix->p;
  for (int k = 0; k < start[s->n]; k++) x[s->place[k]] = values[k];
  s->common.status = CHOLMOD_OK;
  int ok = cholmod_factorize(s->matrix, s->factor, &s->common);
  end_one_thread(levels);
  if (!ok || s->common.status < 0) return -1;
  return s->common.status == CHOLMOD_NOT_POSDEF || s->factor->minor < (size_t)s->n ? 1 : 0;
}

/* b(n, columns) is replaced by the solution. All columns go through the factor together, which takes half the time of
 * one after the other. 0: done. */
int solid_cholmod_solve(solver_t *s, int columns, double *b) {
  size_t n = (size_t)s->n;
  if (columns < 1) return 0;
  int levels = one_thread();
  int ok = cholmod_ensure_dense(&s->rhs, n, (size_t)columns, n, CHOLMOD_REAL, &s->common) != NULL;
  if (ok) {
    double *right = s->rhs->x;
    for (int c = 0; c < columns; c++)
      for (int k = 0; k < s->n; k++) right[c*n + k] = b[c*n + s->order[k]];
    ok = cholmod_solve2(CHOLMOD_A, s->factor, s->rhs, NULL, &s->x, NULL, &s->y, &s->e, &s->common);
  }
  if (ok) {
    const double *x = s->x->x;
    for (int c = 0; c < columns; c++)
      for (int k = 0; k < s->n; k++) b[c*n + s->order[k]] = x[c*n + k];
  }
  end_one_thread(levels);
  return ok ? 0 : -1;
}

/* (smallest/largest diagonal of L)^2, a cheap estimate of 1/condition. */
double solid_cholmod_rcond(solver_t *s) { return cholmod_rcond(s->factor, &s->common); }
