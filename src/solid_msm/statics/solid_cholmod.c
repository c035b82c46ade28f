/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The few CHOLMOD calls that solid_cholesky needs, behind an opaque handle. Fortran cannot name the
 * members of cholmod_common, which are needed to choose the method. */
#define _GNU_SOURCE /* RTLD_DEFAULT, RTLD_NEXT */
#include <cholmod.h>
#include <dlfcn.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* Eight numbers in single precision, which the compiler keeps in registers. */
typedef float eight_t __attribute__((vector_size(32)));
enum { WIDTH = 8 };

/* The factor L in single precision, supernode after supernode: its columns, each with all rows of the supernode, from 0 above the
 * diagonal to zeros behind the last row, so that every column is a whole number of eights. */
typedef struct {
  eight_t *columns;   /* NULL: no room has been made, or CHOLMOD's factor has no supernodes */
  float *reciprocals; /* 1/diagonal of every column */
  eight_t *rows;      /* right-hand side at the rows of a supernode */
  float *x;           /* right-hand side */
  int is_current;     /* it belongs to the last factorisation */
  int is_usable;      /* and L is well enough conditioned */
} rough_t;

typedef struct {
  cholmod_common common;
  cholmod_sparse *matrix; /* lower triangle, rows and columns in the order of elimination */
  int *order;             /* number of each row in the order of elimination, before it */
  int *place;             /* of every given value in the matrix */
  cholmod_factor *factor;
  cholmod_dense *rhs, *x, *y, *e; /* as wide as the widest right-hand side so far */
  rough_t rough;
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
  free(s->rough.columns);
  free(s->rough.reciprocals);
  free(s->rough.rows);
  free(s->rough.x);
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
  s->rough.is_current = 0;
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

/* Two versions of a function; the program takes the one that the processor can run. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define FOR_NEW_PROCESSORS_TOO __attribute__((target_clones("avx2", "default")))
#else
#define FOR_NEW_PROCESSORS_TOO
#endif

/* Eights in a column of supernode k. */
static size_t eights(const cholmod_factor *l, size_t k) {
  const int *pi = l->pi;
  return ((size_t)(pi[k + 1] - pi[k]) + WIDTH - 1)/WIDTH;
}

/* Makes room for the factor in single precision. 0: made. */
static int make_room(solver_t *s) {
  const cholmod_factor *l = s->factor;
  const int *super = l->super;
  size_t total = 0, longest = 1;
  for (size_t k = 0; k < l->nsuper; k++) {
    size_t n = eights(l, k);
    total += n*(size_t)(super[k + 1] - super[k]);
    if (n > longest) longest = n;
  }
  s->rough.columns = aligned_alloc(sizeof(eight_t), (total > 0 ? total : 1)*sizeof(eight_t));
  s->rough.rows = aligned_alloc(sizeof(eight_t), longest*sizeof(eight_t));
  s->rough.reciprocals = malloc((size_t)s->n*sizeof(float));
  s->rough.x = malloc((size_t)s->n*sizeof(float));
  return s->rough.columns && s->rough.rows && s->rough.reciprocals && s->rough.x ? 0 : -1;
}

/* Copies the factor in single precision. */
static void copy_factor(solver_t *s) {
  const double LEAST = 1e-6; /* (smallest/largest diagonal of L)^2; below, the rounding of single precision matters */
  const cholmod_factor *l = s->factor;
  const int *super = l->super, *pi = l->pi, *px = l->px;
  const double *values = l->x;
  float *to = (float *)s->rough.columns;
  double smallest = HUGE_VAL, largest = 0;
  for (size_t k = 0; k < l->nsuper; k++) {
    int n_columns = super[k + 1] - super[k], n_rows = pi[k + 1] - pi[k], length = (int)eights(l, k)*WIDTH;
    for (int j = 0; j < n_columns; j++, to += length) {
      const double *column = values + px[k] + (size_t)j*n_rows;
      for (int i = 0; i < j; i++) to[i] = 0;
      for (int i = j; i < n_rows; i++) to[i] = (float)column[i];
      for (int i = n_rows; i < length; i++) to[i] = 0;
      s->rough.reciprocals[super[k] + j] = (float)(1/column[j]);
      if (column[j] < smallest) smallest = column[j];
      if (column[j] > largest) largest = column[j];
    }
  }
  s->rough.is_current = 1;
  s->rough.is_usable = smallest*smallest > LEAST*largest*largest;
}

/* Sets `rows` to x at the rows of supernode k, and zeros behind the last. */
static void gather(const solver_t *s, size_t k) {
  const int *super = s->factor->super, *pi = s->factor->pi, *row = (const int *)s->factor->s + pi[k];
  int n_columns = super[k + 1] - super[k], n_rows = pi[k + 1] - pi[k], length = (int)eights(s->factor, k)*WIDTH;
  float *w = (float *)s->rough.rows;
  memcpy(w, s->rough.x + super[k], (size_t)n_columns*sizeof *w);
  for (int i = n_columns; i < n_rows; i++) w[i] = s->rough.x[row[i]];
  for (int i = n_rows; i < length; i++) w[i] = 0;
}

/* x becomes L^-1 x. */
FOR_NEW_PROCESSORS_TOO
static void solve_lower(const solver_t *s) {
  const int *super = s->factor->super, *pi = s->factor->pi;
  const eight_t *column = s->rough.columns;
  eight_t *rows = s->rough.rows;
  float *w = (float *)rows, *x = s->rough.x;
  for (size_t k = 0; k < s->factor->nsuper; k++) {
    const int *row = (const int *)s->factor->s + pi[k];
    int n_columns = super[k + 1] - super[k], n_rows = pi[k + 1] - pi[k], n = (int)eights(s->factor, k);
    gather(s, k);
    for (int j = 0; j < n_columns; j++, column += n) {
      float found = w[j]*s->rough.reciprocals[super[k] + j];
      for (int i = j/WIDTH; i < n; i++) rows[i] -= found*column[i];
      x[super[k] + j] = found;
    }
    for (int i = n_columns; i < n_rows; i++) x[row[i]] = w[i];
  }
}

/* x becomes L^-T x. */
FOR_NEW_PROCESSORS_TOO
static void solve_upper(const solver_t *s) {
  const int *super = s->factor->super;
  const eight_t *column = s->rough.columns, *rows = s->rough.rows;
  float *w = (float *)s->rough.rows;
  for (size_t k = 0; k < s->factor->nsuper; k++) column += eights(s->factor, k)*(size_t)(super[k + 1] - super[k]);
  for (size_t k = s->factor->nsuper; k-- > 0;) {
    int n_columns = super[k + 1] - super[k], n = (int)eights(s->factor, k);
    gather(s, k);
    for (int j = n_columns - 1; j >= 0; j--) {
      column -= n;
      float value = w[j];
      eight_t sums = {0}, more = {0};
      w[j] = 0; /* the sum is that of the rows below the diagonal */
      int i = j/WIDTH;
      for (; i + 1 < n; i += 2) {
        sums += column[i]*rows[i];
        more += column[i + 1]*rows[i + 1];
      }
      if (i < n) sums += column[i]*rows[i];
      sums += more;
      value -= ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
      w[j] = value*s->rough.reciprocals[super[k] + j];
      s->rough.x[super[k] + j] = w[j];
    }
  }
}

/* b(n) is replaced by the solution in single precision, which takes a third of the time; in double precision if the matrix is
 * nearly singular or so small that CHOLMOD has no supernodes. 0: done. */
int solid_cholmod_solve_roughly(solver_t *s, double *b) {
  if (!s->factor->is_super) return solid_cholmod_solve(s, 1, b);
  if (!s->rough.x && make_room(s)) return -1;
  if (!s->rough.is_current) copy_factor(s);
  if (!s->rough.is_usable) return solid_cholmod_solve(s, 1, b);
  double largest = 0; /* the range of numbers in single precision is small */
  for (int k = 0; k < s->n; k++) largest = fmax(largest, fabs(b[k]));
  if (largest == 0) return 0;
  for (int k = 0; k < s->n; k++) s->rough.x[k] = (float)(b[s->order[k]]/largest);
  solve_lower(s);
  solve_upper(s);
  for (int k = 0; k < s->n; k++) b[s->order[k]] = largest*s->rough.x[k];
  return 0;
}

/* (smallest/largest diagonal of L)^2, a cheap estimate of 1/condition. */
double solid_cholmod_rcond(solver_t *s) { return cholmod_rcond(s->factor, &s->common); }
