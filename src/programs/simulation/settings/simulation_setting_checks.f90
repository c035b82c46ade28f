! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds mistakes and doubtful values that concern keys of several sections: units, and wings that have no effect.
module simulation_setting_checks
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_magnitude, only: magnitude_doubt, rounded
  use base_text, only: number_text
  use fluid_initial_keys, only: FLOW_MEAN
  use fluid_mean_keys, only: MEAN_FREE
  use fluid_params, only: fluid_params_t
  use fsi_flight_params, only: flight_params_t
  use fsi_wings_key, only: has_flexible_wings
  use io_config, only: config_t
  implicit none
  private
  public :: check_si_numbers, check_wing_use, check_scale, notice_flow, &
            notice_frequency

  real(rp), parameter :: REYNOLDS(2) = [0.1_rp, 1.0e6_rp] !< range of insects and their models, a decade wider on each side
  real(rp), parameter :: VISCOSITY(2) = [5.0e-7_rp, 5.0e-5_rp] !< water to air [m^2/s]
  real(rp), parameter :: WING_SIZE(2) = [0.01_rp, 100.0_rp]    !< of wings, in L
  real(rp), parameter :: FAST = 2.0e4_rp                       !< Reynolds number that no insect has
  real(rp), parameter :: DAMPED(2) = [1.0e-6_rp, 0.3_rp]  !< time in which a wing stops the fluid inside, in beats

contains

  !> Adds a mistake for every number that must be given with input = SI, because nobody would expect its default, which is in L
  !> and T.
  subroutine check_si_numbers(c, fluid, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: fluid
    type(message_list_t), intent(inout) :: errors
    character(2), parameter :: BOX(3) = ['xl', 'yl', 'zl'], MEAN(3) = ['ux', 'uy', 'uz']
    integer :: i
    do i = 1, 3
      call need(fluid%box%has_length(i), 'Geometry', BOX(i))
      if (fluid%mean%kind(i) /= MEAN_FREE .or. fluid%initial%flow == FLOW_MEAN) &
        call need(fluid%mean%has_velocity(i), 'MeanFlow', MEAN(i))
    end do
    call need(fluid%has_nu, 'ReynoldsNumber', 'nu')
    if (fluid%solids%is_on) call need(fluid%solids%has_c_eta, 'Penalization', 'eps')
    if (abs(fluid%initial%omega1) > 0) call c%complain(errors, 'InitialCondition', 'omega1', 'cannot be given with [units] '// &
                                    'input = SI, because its unit depends on inicond; set [units] input = dimensionless for '// &
                                    'this flow')

  contains

    subroutine need(is_given, section, key)
      logical, intent(in) :: is_given
      character(*), intent(in) :: section, key
      if (.not. is_given) &
        call c%complain(errors, section, key, 'is missing: with [units] input = SI it has no default')
    end subroutine need
  end subroutine check_si_numbers

  !> Adds a mistake if the input asks for flexible wings although `moving` says that there are none.
  subroutine check_wing_use(c, moving, errors)
    type(config_t), intent(in) :: c
    logical, intent(in) :: moving
    type(message_list_t), intent(inout) :: errors
    if (moving .or. .not. has_flexible_wings(c)) return
    ! A mistake in the keys of the mask has been reported and may be the only mistake.
    if (is_wrong('iMask') .or. is_wrong('iPenalization')) return
    call c%complain(errors, 'Insects', 'wings', &
                    'there are no wings to bend; valid with [Penalization] iPenalization = yes and iMask = Insect')

  contains

    logical function is_wrong(key)
      character(*), intent(in) :: key
      is_wrong = c%line_of('Penalization', key) > 0 .and. .not. c%is_given('Penalization', key)
    end function is_wrong
  end subroutine check_wing_use

  !> Adds a remark if the wings are orders of magnitude larger or smaller than L, because then one of the two is probably in another
  !> unit. `length` is L in m.
  subroutine check_scale(c, flight, length, errors)
    type(config_t), intent(in) :: c
    type(flight_params_t), intent(in) :: flight
    real(rp), intent(in) :: length
    type(message_list_t), intent(inout) :: errors
    real(rp) :: wing
    if (size(flight%wings) == 0) return
    if (size(flight%wings(1)%points) == 0) return
    wing = flight%wings(1)%length()
    if (wing >= WING_SIZE(1) .and. wing <= WING_SIZE(2)) return
    call c%complain(errors, 'units', 'length', 'L is '//number_text(length)//' m, and the wing is '// &
                    number_text(rounded(wing*length, 3))//' m long; are both in metres? L usually is about as long as the wing')
  end subroutine check_scale

  !> Adds a remark on a viscosity or a penalization that flapping wings do not have, for instance because the user meant another
  !> unit, and on a value that the input does not give. `unit` is L^2/T in m^2/s if the numbers of the input are in L and T, and 0
  !> otherwise.
  subroutine notice_flow(c, fluid, flight, unit, notices)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: fluid
    type(flight_params_t), intent(in) :: flight
    real(rp), intent(in) :: unit
    type(message_list_t), intent(inout) :: notices
    real(rp) :: number
    character(:), allocatable :: text
    if (size(flight%wings) == 0) return
    if (size(flight%wings(1)%points) == 0) return
    if (fluid%nu > 0) then
      number = (flight%tip_speed() + norm2(fluid%mean%velocity))*flight%wings(1)%mean_chord()/fluid%nu
      if (unit > 0 .and. number > FAST .and. fluid%nu >= VISCOSITY(1) .and. fluid%nu <= VISCOSITY(2)) &
        call c%complain(notices, 'ReynoldsNumber', 'nu', 'looks like a value in m^2/s, but its unit here is L^2/T; '// &
                        number_text(fluid%nu)//' m^2/s would be '//number_text(rounded(fluid%nu/unit, 4))//' L^2/T')
      text = magnitude_doubt(number, REYNOLDS(1), REYNOLDS(2), '', 'insects', .false.)
      if (number > 0 .and. text /= '') call c%complain(notices, 'ReynoldsNumber', 'nu', 'makes an unusual Reynolds '// &
                                                       'number: '//text)
      if (.not. fluid%has_nu) call c%complain(notices, 'ReynoldsNumber', 'nu', 'is not given; the '// &
                      'program assumes '// &
                      number_text(fluid%nu)//' L^2/T, which makes the Reynolds number '//number_text(anint(number)))
    else
      call c%complain(notices, 'ReynoldsNumber', 'nu', 'is 0: the fluid has no viscosity; set that of the air or '// &
                      'the water around the insect')
    end if
    if (fluid%solids%is_on .and. .not. fluid%solids%has_c_eta) call c%complain(notices, 'Penalization', 'eps', &
      'is not given; the program assumes '//number_text(fluid%solids%c_eta)//' T, in which a wing stops the fluid inside')
    number = fluid%solids%c_eta*flight%frequency()
    text = magnitude_doubt(number, DAMPED(1), DAMPED(2), 'beats', 'wings that hold the fluid', .false.)
    if (fluid%solids%is_on .and. number > 0 .and. text /= '') call c%complain(notices, 'Penalization', 'eps', text)
  end subroutine notice_flow

  !> Adds a remark if the number of `beats` in every T was probably meant in 1/s. `frequency` is 1/T in 1/s.
  subroutine notice_frequency(beats, frequency, notices)
    real(rp), intent(in) :: beats, frequency
    type(message_list_t), intent(inout) :: notices
    if (abs(beats - frequency) > 1.0e-9_rp*frequency .or. abs(beats - 1) <= 1.0e-9_rp) return
    call notices%add('[Insects] wing_frequency equals [units] frequency, but its unit is 1/T: there are '//number_text(beats)// &
                     ' beats in every T; wing_frequency = 1 gives one beat in every T')
  end subroutine notice_frequency
end module simulation_setting_checks
