! SPDX-License-Identifier: GPL-3.0-or-later
!> Which measurement tells the possible causes apart best (Atkinson and Fedorov 1975, DOI 10.1093/biomet/62.1.57: the
!> design that maximises the sum of squares by which rival models must differ).
!>
!> The rivals are the first cause and the one that imitates it best. What the second cannot imitate of the first, at
!> the strength found, is a sum of squares over all loads; a load that is repeated adds its share once more, and a load
!> at a new place adds what it says about both rivals and the baseline, which is fitted anew to all.
module app_diagnose_next
  use app_diagnose_places, only: new_load_t, normal_matrix, separation, shared_columns, try_loads
  use app_diagnose_settings, only: diagnose_settings_t
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use diagnosis_engine, only: diagnosis_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  implicit none
  private
  public :: next_t, rank_loads, rank_places, write_next

  integer, parameter :: MOST_PLACES = 10

  !> The ranking; empty without two rivals.
  type :: next_t
    integer :: effects(2) = 0                !< the rivals
    integer :: candidates(2) = 0             !< their variants
    real(rp) :: separation = 0               !< sd between them now
    real(rp), allocatable :: after(:)        !< (loads) with this load once more
    integer, allocatable :: order(:)         !< loads, the best first
    type(new_load_t), allocatable :: places(:) !< loads at new places, the best first
  end type next_t

contains

  !> Ranks the loads of the measurement.
  function rank_loads(simulator, d) result(next)
    type(wing_simulator_t), intent(in) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(next_t) :: next
    real(rp), allocatable :: signal(:), left(:), squares(:)
    real(rp) :: least
    integer :: c, l, n
    n = size(simulator%labels%fold)
    allocate (next%after(0), next%order(0), next%places(0))
    if (size(d%decision%causes) == 0) return
    associate (first => d%design%candidates(d%decision%causes(1)))
      signal = matmul(first%basis, matmul(d%z, first%basis))
      least = huge(least)
      do c = 1, size(d%design%candidates)
        associate (other => d%design%candidates(c))
          if (other%effect == first%effect .or. other%df == 0) cycle
          left = signal - matmul(other%basis, matmul(signal, other%basis))
          if (.not. sum(left**2) < least) cycle
          least = sum(left**2)
          next%effects = [first%effect, other%effect]
          next%candidates = [d%decision%causes(1), c]
          squares = d%design%by_surface(left, simulator%labels%surface, n)
        end associate
      end do
    end associate
    if (next%effects(1) == 0) return
    next%separation = sqrt(least)
    next%after = sqrt(least + squares)
    do l = 1, n
      c = maxloc(squares, 1)
      next%order = [next%order, c]
      squares(c) = -1
    end do
  end function rank_loads

  !> Adds loads at new places to a ranking. On rank 0; the others serve.
  subroutine rank_places(s, simulator, d, next)
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(next_t), intent(inout) :: next
    type(new_load_t), allocatable :: loads(:)
    integer, allocatable :: columns(:), cause(:), shared(:)
    real(rp), allocatable :: normal(:, :), strength(:), shared_sd(:)
    real(rp) :: now
    integer :: i, k
    logical :: ok
    if (next%effects(1) == 0 .or. .not. d%extended%is_found) return
    associate (first => d%design%candidates(next%candidates(1)), other => d%design%candidates(next%candidates(2)))
      cause = first%columns
      call shared_columns(s, shared, shared_sd)
      columns = [d%baseline%active, shared, &
                 pack(other%columns, [(all(cause /= other%columns(i)), i=1, size(other%columns))]), cause]
    end associate
    strength = d%extended%q(cause) - d%baseline%q(cause)
    allocate (normal(size(columns), size(columns)))
    call normal_matrix(simulator, d%baseline%q, columns, shared_sd, normal, ok)
    now = separation(normal, strength)
    if (.not. (ok .and. now > 0)) return
    call try_loads(s, simulator, d%baseline%q, columns, loads)
    do i = 1, size(loads)
      loads(i)%after = next%separation*separation(normal + loads(i)%normal, strength)/now
    end do
    do i = 1, min(MOST_PLACES, size(loads))
      k = maxloc(loads%after, 1)
      next%places = [next%places, loads(k)]
      loads(k)%after = -1
    end do
  end subroutine rank_places

  !> Writes NAME_next_measurements.csv.
  subroutine write_next(settings, next, failure)
    type(diagnose_settings_t), intent(in) :: settings
    type(next_t), intent(in) :: next
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text
    character(160) :: line
    integer :: i
    logical :: ok
    text = 'rank,load,x [m],y [m],force [N],separation now [sd],separation with it once more [sd]'//new_line('a')
    do i = 1, size(next%order)
      associate (load => settings%measurement%loads(next%order(i)))
        write (line, '(a,4(",",es12.5))') ',', load%point, load%force, next%separation
        text = text//number_text(i)//','//load%name//trim(line(2:))
        write (line, '(",",es12.5)') next%after(next%order(i))
        text = text//trim(line)//new_line('a')
      end associate
    end do
    do i = 1, size(next%places)
      associate (load => next%places(i))
        write (line, '(a,5(",",es12.5))') ',', load%place, load%force*sign(1.0_rp, load%direction(3)), &
          next%separation, load%after
        text = text//number_text(i)//',(new place)'//trim(line(2:))//new_line('a')
      end associate
    end do
    call write_text(settings%name//'_next_measurements.csv', text, ok)
    if (.not. ok) call failure%raise(settings%name//'_next_measurements.csv: cannot be written; is the disk full?')
  end subroutine write_next
end module app_diagnose_next
