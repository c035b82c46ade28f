! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes `summary.txt` of a run with flapping wings: lift, drag and power averaged over wing beats, as in Table 2 of the paper,
!> both normalised and in SI units.
!>
!> It computes everything from the series on the disk, so that a run in several parts has one summary.
module simulation_summary
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use fluid_penalty, only: N_COLORS
  use fsi_beats, only: complete_beats, beat_statistics, beat_t
  use io_series_read, only: read_series
  use simulation_free_flight, only: free_flight_text
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: write_summary

  character(*), parameter :: NL = new_line('a')
  integer, parameter :: FORCE_COLUMNS = 15, SLIP_COLUMNS = 1 + N_COLORS, THIN_COLUMNS = 8, &
                        COUPLING_COLUMNS = 11
  real(rp), parameter :: START = 0.1_rp !< fraction of the first beat in which the flow starts suddenly, with large forces
  integer, parameter :: LIFT = 1, DRAG = 2, SIDE = 3, POWER = 4, INERTIAL = 5
  character(18), parameter :: NAMES(5) = [character(18) :: 'lift', 'drag', 'side force', 'aerodynamic power', &
                                                                                                   'inertial power']

contains

  !> Writes `summary.txt` and prints it, if the series hold at least one whole wing beat. Fails if the file cannot be written or
  !> a series cannot be read. For root alone.
  subroutine write_summary(settings, name, failure)
    type(settings_t), intent(in) :: settings
    character(*), intent(in) :: name !< of the run
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: series(:, :), values(:, :)
    type(beat_t), allocatable :: beats(:, :)
    type(beat_t) :: beat
    character(:), allocatable :: text
    real(rp) :: period, lost
    integer :: n, k, q, i
    if (size(settings%flight%wings) == 0) return ! a body alone has no beat
    call read_series('forces.t', FORCE_COLUMNS, series, failure)
    if (failure%failed) return
    period = 1/settings%flight%frequency()
    n = complete_beats(series(1, :), period)
    if (n < 1) return
    call quantities(settings, series, values)
    allocate (beats(size(NAMES), n))
    do k = 1, n
      do q = 1, size(NAMES)
        beats(q, k) = beat_statistics(series(1, :), values(q, :), period, k, merge(START*period, 0.0_rp, k == 1))
      end do
    end do
    text = summary_text(settings, name, beats)
    call add_body(settings, period, n, text, failure)
    if (settings%flight%flyer%is_free) text = text//free_flight_text(settings%flight, settings%fluid, beats(LIFT, n)%mean, &
                                                                     (n - 1)*period, n*period, failure)
    if (failure%failed) return
    if (settings%flight%thin%is_thin) then
      call read_series('slip.t', THIN_COLUMNS, series, failure)
      if (failure%failed) return
      text = text//thin_slip_text(settings, series, period, n)
      ! Both powers are of the same steps: the ratio of means over other steps would depend on slip_interval.
      beat = beat_statistics(series(1, :), series(8, :), period, n)
      lost = beat%mean
      beat = beat_statistics(series(1, :), series(5, :), period, n)
      if (has_rows(series(1, :), period, n)) text = text//balance_text(lost, beat, 0.98_rp, 'set a smaller CFL')
    else
      call read_series('u_residual.t', SLIP_COLUMNS, series, failure)
      if (failure%failed) return
      text = text//slip_text(settings, series, period, n)
      lost = 0
      do i = 1, merge(size(settings%flight%wings), 0, settings%flexible)
        call read_series('coupling_'//trim(settings%flight%wings(i)%side)//'.t', COUPLING_COLUMNS, series, failure)
        if (failure%failed) return
        beat = beat_statistics(series(1, :), series(8, :), period, n)
        lost = lost + beat%mean
      end do
      if (settings%flexible) text = text//balance_text(lost, beats(POWER, n), 0.8_rp, &
                                     'use wings without thickness, [Insects] surface = thin, or a finer grid')
    end if
    write (output_unit, '(a)') '', text
    call write_text('summary.txt', text, failure)
  end subroutine write_summary

  !> Adds to `text` the lift, drag and power of the body in the last of n beats, if there is a body.
  subroutine add_body(settings, period, n, text, failure)
    type(settings_t), intent(in) :: settings
    real(rp), intent(in) :: period
    integer, intent(in) :: n
    character(:), allocatable, intent(inout) :: text
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: series(:, :), values(:, :)
    type(beat_t) :: beats(3)
    character(140) :: line
    real(rp) :: r, f
    integer :: i
    if (.not. settings%flight%solid%exists()) return
    call read_series('forces_part1.t', FORCE_COLUMNS, series, failure)
    if (failure%failed) return
    call quantities(settings, series, values)
    do i = 1, 3
      beats(i) = beat_statistics(series(1, :), values(merge(POWER, i, i == 3), :), period, n)
    end do
    r = settings%flight%wings(1)%length()
    f = settings%flight%frequency()
    write (line, '(a,3f12.5,a)') 'body', beats%mean/[r**4*f**2, r**4*f**2, r**5*f**3], &
      '               of these in the last beat'
    text = text//trim(line)//NL
  end subroutine add_body

  !> Returns lift, drag and so on as values(quantity, record) from the records of forces.t. Lift points along z. Drag points
  !> along the horizontal mean flow, or along x if there is none.
  subroutine quantities(settings, series, values)
    type(settings_t), intent(in) :: settings
    real(rp), intent(in) :: series(:, :)
    real(rp), allocatable, intent(out) :: values(:, :)
    real(rp) :: wind(2), force(3, size(series, 2))
    wind = settings%fluid%mean%velocity(1:2)
    if (norm2(wind) <= 0) wind = [1.0_rp, 0.0_rp]
    wind = wind/norm2(wind)
    force = series(2:4, :) + series(5:7, :)
    allocate (values(size(NAMES), size(series, 2)))
    values(LIFT, :) = force(3, :)
    values(DRAG, :) = wind(1)*force(1, :) + wind(2)*force(2, :)
    values(SIDE, :) = wind(1)*force(2, :) - wind(2)*force(1, :)
    values(POWER, :) = series(14, :)
    values(INERTIAL, :) = series(15, :)
  end subroutine quantities

  !> Returns the summary of a flight: the mean values of its last beats, their peaks and their spread.
  function summary_text(settings, name, beats) result(text)
    type(settings_t), intent(in) :: settings
    character(*), intent(in) :: name
    type(beat_t), intent(in) :: beats(:, :) !< (quantity, beat)
    character(:), allocatable :: text
    character(200) :: line
    real(rp) :: unit(size(NAMES)), si(size(NAMES)), r, f
    integer :: n, first, q, k
    n = size(beats, 2)
    first = n - (n - 1)/2 ! the second half: 3 and 4 of 4
    r = settings%flight%wings(1)%length()
    f = settings%flight%frequency()
    unit = 1/(r**4*f**2)
    unit(POWER:) = 1/(r**5*f**3)
    associate (u => settings%units)
      si = 1.0e3_rp*u%density*u%length**4*u%frequency**2
      si(POWER:) = si(POWER:)*u%length*u%frequency
    end associate
    text = 'flusi-msm '//BUILD_VERSION//' ('//BUILD_COMMIT//'), '//name//NL//NL
    write (line, '(a,i0,a,i0,a,i0,2(a,es11.4))') 'wing beats ', first, ' to ', n, ' of ', n, '; R =', r, ' L, f =', f
    text = text//trim(line)//' 1/T; lift along z, drag along the mean flow'//NL
    text = text//'peak: the largest value of a beat; spread: half the range over these beats'//NL
    if (first == 1) text = text//'peaks leave out the first tenth of the beat, in which the flow starts'//NL
    text = text//NL
    text = text//repeat(' ', 23)//'normalised by rho R^4 f^2, rho R^5 f^3'
    if (settings%units%given) text = text//repeat(' ', 12)//'SI [mN, mW]'
    text = text//NL//'                   '//repeat('        mean      spread        peak      spread', &
                                                  merge(2, 1, settings%units%given))//NL
    do q = 1, size(NAMES)
      associate (b => beats(q, first:))
        write (line, '(a18,8f12.5)') NAMES(q), four_numbers(b, unit(q)), four_numbers(b, si(q))
        if (.not. settings%units%given) line(67:) = ''
        text = text//trim(line)//NL
      end associate
    end do
    text = text//NL//repeat(' ', 27)//'mean      spread'//NL
    associate (b => beats(:, first:)%mean)
      text = text//ratio('lift / drag', b(LIFT, :), b(DRAG, :))
      text = text//ratio('lift / power', b(LIFT, :)*unit(LIFT), b(POWER, :)*unit(POWER))
      if (settings%units%given) text = text//ratio('lift / power, mN/mW', b(LIFT, :)*si(LIFT), b(POWER, :)*si(POWER))
    end associate
    text = text//NL//'beat        lift        drag       power    inertial   (means, normalised)'//NL
    do k = 1, n
      write (line, '(i4,4f12.5)') k, beats([LIFT, DRAG, POWER, INERTIAL], k)%mean*unit([LIFT, DRAG, POWER, INERTIAL])
      text = text//trim(line)//NL
    end do
  end function summary_text

  !> Returns the mean and spread of the means, and the mean and spread of the peaks, of some beats, multiplied by `unit`.
  pure function four_numbers(b, unit) result(x)
    type(beat_t), intent(in) :: b(:)
    real(rp), intent(in) :: unit
    real(rp) :: x(4)
    x = unit*[sum(b%mean)/size(b), (maxval(b%mean) - minval(b%mean))/2, &
              sum(b%largest)/size(b), (maxval(b%largest) - minval(b%largest))/2]
  end function four_numbers

  !> Tells whether two or more of `times` lie in beat n.
  pure logical function has_rows(times, period, n)
    real(rp), intent(in) :: times(:), period
    integer, intent(in) :: n
    has_rows = count(times >= (n - 1)*period .and. times <= n*period) > 1
  end function has_rows

  !> Returns how well the flow follows wings without thickness in the last beat.
  function thin_slip_text(settings, series, period, n) result(text)
    type(settings_t), intent(in) :: settings
    real(rp), intent(in) :: series(:, :) !< of slip.t
    real(rp), intent(in) :: period
    integer, intent(in) :: n
    character(:), allocatable :: text
    real(rp), parameter :: MUCH = 0.02_rp
    type(beat_t) :: beat
    character(160) :: line
    real(rp) :: fraction
    text = ''
    if (settings%flight%tip_speed() <= 0) return
    if (.not. has_rows(series(1, :), period, n)) then
      text = NL//'slip        was not measured in the last beat ([Insects] slip_interval)'//NL
      return
    end if
    beat = beat_statistics(series(1, :), series(2, :), period, n)
    fraction = beat%mean/settings%flight%tip_speed()
    write (line, '(a,f0.2,a)') 'slip        the largest |u - u_s| at a marker is ', 100*fraction, &
      ' % of the mean tip speed (mean of the last beat)'
    text = NL//trim(line)//NL
    if (maxval(series(6, :)) > 0) then
      beat = beat_statistics(series(1, :), series(6, :), period, n)
      write (line, '(2(a,f0.1),a)') '            the forces of all wings took ', beat%mean, ' iterations a step, at most ', &
        beat%largest, ', in the steps of slip.t'
      text = text//trim(line)//NL
    end if
    if (fraction > MUCH) text = text//'            the flow does not follow the wings well: set a smaller CFL'//NL
  end function thin_slip_text

  !> Returns whether the flow receives the power that the wings lose, in the mean of the last beat. It is empty for wings that
  !> exchange power with the flow but lose none in the mean.
  function balance_text(lost, received, least, advice) result(text)
    real(rp), intent(in) :: lost, least
    type(beat_t), intent(in) :: received
    character(*), intent(in) :: advice
    character(:), allocatable :: text
    character(160) :: line
    real(rp), parameter :: LITTLE = 0.05_rp
    real(rp) :: ratio
    text = ''
    if (.not. abs(received%mean) > LITTLE*abs(received%largest)) return
    ratio = lost/received%mean
    write (line, '(a,f0.3,a)') 'balance     the power that the wings lose is ', ratio, &
      ' of the power that the flow receives (last beat)'
    text = trim(line)//NL
    if (ratio < least .or. ratio > 1/least) text = text//'            these should be equal: '//advice//NL
  end function balance_text

  !> Returns how much flow passes through the wings, which are porous: the slip is about (pressure difference) C_eta/thickness.
  function slip_text(settings, series, period, n) result(text)
    type(settings_t), intent(in) :: settings
    real(rp), intent(in) :: series(:, :) !< of u_residual.t
    real(rp), intent(in) :: period
    integer, intent(in) :: n
    character(:), allocatable :: text
    real(rp), parameter :: MUCH = 0.1_rp
    type(beat_t) :: beat
    character(160) :: line
    real(rp) :: fraction
    integer :: i
    text = ''
    if (settings%flight%tip_speed() <= 0) return
    fraction = 0
    do i = 1, size(settings%flight%wings)
      beat = beat_statistics(series(1, :), series(2 + settings%flight%wings(i)%color, :), period, n)
      fraction = max(fraction, beat%mean/settings%flight%tip_speed())
    end do
    write (line, '(a,f0.1,a)') 'slip        rms |u - u_s| inside the wings is ', 100*fraction, &
      ' % of the mean tip speed (last beat)'
    text = NL//trim(line)//NL
    if (fraction > MUCH) text = text//'            the flow leaks through the wings, and the forces are too small; the slip '// &
                                'is proportional to eps'//NL
  end function slip_text

  !> Returns the ratio of the means over some beats, with half the range of the ratios of the beats.
  function ratio(name, a, b) result(text)
    character(*), intent(in) :: name
    real(rp), intent(in) :: a(:), b(:)
    character(:), allocatable :: text
    character(60) :: line
    if (any(abs(b) <= tiny(b))) then
      write (line, '(a20,a11)') name, '-'
    else
      write (line, '(a20,2f12.4)') name, sum(a)/sum(b), (maxval(a/b) - minval(a/b))/2
    end if
    text = trim(line)//NL
  end function ratio
end module simulation_summary
