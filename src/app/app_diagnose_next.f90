! SPDX-License-Identifier: GPL-3.0-or-later
!> Which measurement tells the possible causes apart best (Atkinson and Fedorov 1975, DOI 10.1093/biomet/62.1.57: the
!> design that maximises the sum of squares by which rival models must differ).
!>
!> The rivals are the first cause and the one that imitates it best. What the second cannot imitate of the first, at
!> the strength found, is a sum of squares over all loads; a load that is repeated adds its share once more.
module app_diagnose_next
  use app_diagnose_settings, only: diagnose_settings_t
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use diagnosis_engine, only: diagnosis_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  implicit none
  private
  public :: next_t, rank_loads, write_next

  !> The ranking; empty without two rivals.
  type :: next_t
    integer :: effects(2) = 0                !< the rivals
    real(rp) :: separation = 0               !< sd between them now
    real(rp), allocatable :: after(:)        !< (loads) with this load once more
    integer, allocatable :: order(:)         !< loads, the best first
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
    allocate (next%after(0), next%order(0))
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
    call write_text(settings%name//'_next_measurements.csv', text, ok)
    if (.not. ok) call failure%raise(settings%name//'_next_measurements.csv: cannot be written; is the disk full?')
  end subroutine write_next
end module app_diagnose_next
