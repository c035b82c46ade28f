! SPDX-License-Identifier: GPL-3.0-or-later
!> What `summary.txt` says of the power that the wings lose and the flow receives, from series that are written here: it warns
!> if wings without thickness lose less than 0.98 of it, wings in the mask less than 0.8, or as much more.
program test_summary
  use, intrinsic :: iso_fortran_env, only: error_unit
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use fluid_penalty, only: N_COLORS
  use simulation_settings, only: load_settings, settings_t
  use simulation_summary, only: write_summary
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = new_line('a')
  character(*), parameter :: WARNING = 'these should be equal'
  integer, parameter :: LIFT = 4, POWER = 14, SLIP_RECEIVED = 5, SLIP_LOST = 8, COUPLING_LOST = 8
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call thin_wings()
  call penalized_wings()
  call t%finish()

contains

  !> The summary of wings without thickness compares powers of the same steps, whatever forces.t has, which has more of them.
  subroutine thin_wings()
    real(rp), parameter :: RATIOS(4) = [1.0_rp, 0.985_rp, 0.975_rp, 1.03_rp]
    logical, parameter :: WARNS(4) = [.false., .false., .true., .true.]
    character(:), allocatable :: text
    integer :: i
    call write_series('forces.t', 15, 200, [LIFT, POWER], [1.0_rp, 0.9_rp])
    do i = 1, size(RATIOS)
      call write_series('slip.t', 8, 7, [SLIP_RECEIVED, SLIP_LOST], [1.0_rp, RATIOS(i)])
      call summarise('thin', .false., text)
      call t%check('thin: the ratio is that of slip.t', index(text, ratio_text(RATIOS(i))) > 0)
      call t%check('thin: a warning at '//ratio_text(RATIOS(i)), (index(text, WARNING) > 0) .eqv. WARNS(i))
      call t%check('thin: what to do', (index(text, 'set a smaller CFL') > 0) .eqv. WARNS(i))
    end do
  end subroutine thin_wings

  !> The load on wings in the mask is that of coupling_*.t.
  subroutine penalized_wings()
    real(rp), parameter :: RATIOS(3) = [0.82_rp, 0.78_rp, 1.3_rp]
    logical, parameter :: WARNS(3) = [.false., .true., .true.]
    character(:), allocatable :: text
    integer :: i
    call write_series('forces.t', 15, 200, [LIFT, POWER], [1.0_rp, 1.0_rp])
    call write_series('u_residual.t', 1 + N_COLORS, 200, [2], [0.01_rp])
    do i = 1, size(RATIOS)
      call write_series('coupling_left.t', 11, 200, [COUPLING_LOST], [RATIOS(i)/2])
      call write_series('coupling_right.t', 11, 200, [COUPLING_LOST], [RATIOS(i)/2])
      call summarise('penalized', .true., text)
      call t%check('penalized: the ratio is that of both wings', index(text, ratio_text(RATIOS(i))) > 0)
      call t%check('penalized: a warning at '//ratio_text(RATIOS(i)), (index(text, WARNING) > 0) .eqv. WARNS(i))
      call t%check('penalized: what to do', (index(text, 'surface = thin') > 0) .eqv. WARNS(i))
    end do
    call summarise('penalized', .false., text)
    call t%check('rigid wings in the mask have no balance', index(text, 'balance') == 0)
  end subroutine penalized_wings

  function ratio_text(ratio) result(text)
    real(rp), intent(in) :: ratio
    character(:), allocatable :: text
    character(40) :: line
    write (line, '(f0.3)') ratio
    text = trim(line)//' of the power that the flow receives'
  end function ratio_text

  !> Writes a series over two beats with n rows. Columns that are named have means in the given proportion, and swing about them by
  !> half of them with the beat; others are 0.
  subroutine write_series(name, columns, n, which, means)
    character(*), intent(in) :: name
    integer, intent(in) :: columns, n, which(:)
    real(rp), intent(in) :: means(:)
    type(failure_t) :: failure
    character(:), allocatable :: text
    character(400) :: line
    real(rp) :: row(columns), phase
    integer :: i
    text = '% written by a test'//NL
    do i = 0, n
      phase = 4*acos(-1.0_rp)*i/n
      row = 0
      row(1) = 2*real(i, rp)/n
      row(which) = means*(1 + 0.5_rp*sin(2*phase + 1))
      write (line, '(*(es17.8))') row
      text = text//trim(line)//NL
    end do
    call write_text(name, text, failure)
    call t%check(name//' is written', .not. failure%failed)
  end subroutine write_series

  !> Returns the summary of the series as they are.
  subroutine summarise(surface, is_flexible, summary)
    character(*), intent(in) :: surface
    logical, intent(in) :: is_flexible
    character(:), allocatable, intent(out) :: summary
    type(settings_t) :: settings
    type(message_list_t) :: errors, notices
    type(failure_t) :: failure
    character(300) :: line
    integer :: unit, status
    call load_settings('[InitialCondition]'//NL//'inicond=quiescent'//NL// &
                       '[Resolution]'//NL//'nx=32'//NL//'ny=32'//NL//'nz=32'//NL//'[Penalization]'//NL//'iPenalization=1'//NL// &
                       'iMask=Insect'//NL//'eps=0.01'//NL//'[Insects]'//NL//'surface='//surface//NL//'WingShape=drosophila'//NL// &
                       'x_pivot_l=0.0 0.2 0.0'//NL//'x_pivot_r=0.0 -0.2 0.0'//NL// &
                       'FlappingMotion_left=Drosophila_hovering_fry'//NL//'FlappingMotion_right=Drosophila_hovering_fry'//NL, &
                       'test.ini', .false., settings, errors, notices)
    call t%check('the settings are accepted', errors%count() == 0)
    call errors%print(error_unit, '')
    settings%flexible = is_flexible
    call write_summary(settings, 'test', failure)
    call t%check('the summary is written', .not. failure%failed)
    summary = ''
    open (newunit=unit, file='summary.txt', status='old', action='read')
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      summary = summary//trim(line)//NL
    end do
    close (unit)
  end subroutine summarise
end program test_summary
