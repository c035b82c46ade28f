! SPDX-License-Identifier: GPL-3.0-or-later
!> The farm of tasks: the same results to the bit whoever does them and in whatever order, more tasks than
!> ranks and fewer, failures as statuses, shared contexts, early ends without deadlock.
program test_farm
  use base_kinds, only: rp, i8
  use base_random, only: random_uniforms
  use parallel_farm, only: farm_t, NOT_RUN
  use parallel_world, only: world_t
  use test_farm_runner, only: sleepy_t, expected, FAILING
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_INPUT = 3, N_OUTPUT = 4
  integer, parameter :: COUNTS(7) = [23, 1, 2, 0, 6, 7, 60]
  integer, parameter :: N_FAILING = 18 ! of these tasks every fifth of a batch fails
  type(testkit_t) :: t
  type(sleepy_t) :: runner
  integer :: i
  logical :: root_works

  call t%start(parallel=.true.)
  do i = 0, 1
    root_works = i == 1
    call test_batches()
    call test_stop()
    call test_shut_down()
  end do
  call test_order()
  call t%finish()

contains

  !> Several batches with outputs and contexts of several lengths, under one `serve`.
  subroutine test_batches()
    type(farm_t) :: farm
    real(rp), allocatable :: inputs(:, :), outputs(:, :), seconds(:), context(:), want(:)
    integer, allocatable :: statuses(:), order(:)
    integer :: batch, n, k, n_wrong, n_failed, length
    n_wrong = 0
    n_failed = 0
    call farm%start(t%world, N_INPUT, N_OUTPUT, root_works)
    if (t%world%is_root) then
      do batch = 1, size(COUNTS)
        n = COUNTS(batch)
        context = [(sqrt(real(k + batch, rp)), k=1, batch)]
        call farm%broadcast(runner, context)
        length = N_OUTPUT - modulo(batch, 3)
        allocate (inputs(N_INPUT, n), outputs(length, n), seconds(n), statuses(n), want(length))
        order = [(n + 1 - k, k=1, n)]
        do k = 1, n
          inputs(1, k) = k
          inputs(2:3, k) = random_uniforms(7_i8, int(batch, i8), int(k, i8))
        end do
        call farm%run(runner, order, inputs, outputs, statuses, seconds)
        do k = 1, n
          call expected(inputs(:, k), context, want)
          if (any(abs(outputs(:, k) - want) > 0)) n_wrong = n_wrong + 1
          if (statuses(k) /= merge(FAILING, 0, modulo(k, 5) == 0)) n_wrong = n_wrong + 1
          if (statuses(k) == FAILING) n_failed = n_failed + 1
          if (.not. seconds(k) >= 0) n_wrong = n_wrong + 1
        end do
        deallocate (inputs, outputs, seconds, statuses, want)
        if (batch == 3) call farm%meet(runner)
      end do
      call farm%shut_down()
    else
      call farm%serve(runner)
    end if
    call t%check('every output is that of its own task, to the bit', n_wrong == 0)
    call t%check('failures are statuses', n_failed == N_FAILING .or. .not. t%world%is_root)
    call t%check('all ranks have met between two batches', runner%n_met == t%world%size)
    call t%check('every rank has the last context', size(runner%context) == size(COUNTS))
  end subroutine test_batches

  !> A stop that is wanted in the middle: what was begun is finished, the rest is marked, and the next
  !> batch runs as if nothing had happened.
  subroutine test_stop()
    integer, parameter :: N = 40
    type(farm_t) :: farm
    real(rp) :: inputs(N_INPUT, N), outputs(N_OUTPUT, N), seconds(N), want(N_OUTPUT)
    integer :: statuses(N), k
    logical :: is_right
    call farm%start(t%world, N_INPUT, N_OUTPUT, root_works)
    is_right = .true.
    if (t%world%is_root) then
      call farm%broadcast(runner, [1.0_rp])
      inputs = 0.1_rp
      inputs(1, :) = [(k, k=1, N)]
      runner%questions_left = 3
      call farm%run(runner, [(k, k=1, N)], inputs, outputs, statuses, seconds)
      is_right = any(statuses == NOT_RUN) .and. any(statuses /= NOT_RUN)
      do k = 1, N
        if (statuses(k) == NOT_RUN) then
          is_right = is_right .and. all(abs(outputs(:, k)) <= 0)
        else
          call expected(inputs(:, k), [1.0_rp], want)
          is_right = is_right .and. all(abs(outputs(:, k) - want) <= 0)
        end if
      end do
      runner%questions_left = huge(1)
      call farm%run(runner, [(k, k=1, N)], inputs, outputs, statuses, seconds)
      is_right = is_right .and. all(statuses /= NOT_RUN)
      call farm%shut_down()
    else
      call farm%serve(runner)
    end if
    call t%check('a batch can end early and another begin', is_right)
  end subroutine test_stop

  !> Workers that never get a task go home.
  subroutine test_shut_down()
    type(farm_t) :: farm
    call farm%start(t%world, N_INPUT, N_OUTPUT, root_works)
    if (t%world%is_root) then
      call farm%shut_down()
    else
      call farm%serve(runner)
    end if
    call t%check('a farm can close without work', .true.)
  end subroutine test_shut_down

  !> With one rank tasks are begun in the order that was asked for.
  subroutine test_order()
    type(farm_t) :: farm
    real(rp) :: inputs(N_INPUT, 3), outputs(N_OUTPUT, 3), seconds(3)
    integer :: statuses(3)
    logical :: in_order
    call farm%start(t%world, N_INPUT, N_OUTPUT)
    in_order = .true.
    if (t%world%is_root) then
      call farm%broadcast(runner, [1.0_rp])
      inputs = 0
      inputs(1, :) = [1.0_rp, 2.0_rp, 3.0_rp]
      runner%n_done = 0
      call farm%run(runner, [2, 3, 1], inputs, outputs, statuses, seconds)
      if (t%world%size == 1) in_order = all(runner%done(:3) == [2, 3, 1])
      call farm%shut_down()
    else
      call farm%serve(runner)
    end if
    call t%check('one rank begins tasks in the order given', in_order)
  end subroutine test_order
end program test_farm
