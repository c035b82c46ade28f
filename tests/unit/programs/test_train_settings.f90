! SPDX-License-Identifier: GPL-3.0-or-later
!> Every key of [CMAES] reaches the search: values that no key has by default are read from an ini file, for the wing in
!> the file that the first argument names.
program test_train_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use cmaes_options, only: CONSTANTS_PAPER, WEIGHTS_ACTIVE, WEIGHTS_PAPER, WEIGHTS_POSITIVE
  use cmaes_search, only: RESTARTS_BIPOP
  use common_train_keys, only: register_train_keys
  use io_registry, only: registry_t
  use measurement_data, only: measurement_t
  use solid_usual_causes, only: PARAM_YOUNG
  use testkit, only: testkit_t
  use train_settings, only: load_train_settings, train_settings_t
  use whole_measurement, only: write_measurement
  implicit none
  character(*), parameter :: NL = new_line('a')
  integer, parameter :: N = 24
  !> `weights` in a file of its own: alpha_minus goes with the usual ones only.
  character(*), parameter :: NAMES(N) = [character(16) :: &
                                         'lambda', 'mu', 'sigma0', 'constants', 'restarts', 'max_restarts', &
                                         'max_generations', 'max_evaluations', 'target', 'tolfun', 'tolfunhist', &
                                         'tolx', 'tolstagnation', 'condition_limit', 'c_m', 'c_sigma', 'd_sigma', &
                                         'c_c', 'c_1', 'c_mu', 'alpha_minus', 'tolfacupx', 'tolupsigma', &
                                         'tolflatfitness']
  character(*), parameter :: VALUES(N) = [character(8) :: &
                                          '9', '3', '0.21', 'paper', 'bipop', '7', '123', '4567', '0.25', '1.1e-4', &
                                          '1.2e-5', '1.3e-6', '17', '1e9', '0.9', '0.31', '1.7', '0.41', '0.11', &
                                          '0.12', '0.7', '77', '1e7', '5']
  type(testkit_t) :: t
  type(train_settings_t) :: s
  character(:), allocatable :: keys
  integer :: i

  call t%start(parallel=.true.)
  call write_flat_measurement('flat.h5')
  keys = ''
  do i = 1, N
    keys = keys//trim(NAMES(i))//' = '//trim(VALUES(i))//';'//NL
  end do
  call read_settings(keys)
  associate (o => s%search)
    call t%check('lambda', o%lambda == 9)
    call t%check('mu', o%mu == 3)
    call t%check_close('sigma0', o%sigma0, 0.21_rp)
    call t%check('constants', o%constants == CONSTANTS_PAPER)
    call t%check('restarts', s%restarts == RESTARTS_BIPOP)
    call t%check('max_restarts', s%max_restarts == 7)
    call t%check('max_generations', o%max_iterations == 123)
    call t%check('max_evaluations', o%max_evaluations == 4567)
    call t%check_close('target', o%f_target, 0.25_rp)
    call t%check_close('tolfun', o%tolfun, 1.1e-4_rp)
    call t%check_close('tolfunhist', o%tolfunhist, 1.2e-5_rp)
    call t%check_close('tolx', o%tolx, 1.3e-6_rp)
    call t%check('tolstagnation', o%tolstagnation == 17)
    call t%check_close('condition_limit', o%condition_limit, 1.0e9_rp)
    call t%check_close('c_m', o%c_m, 0.9_rp)
    call t%check_close('c_sigma', o%c_sigma, 0.31_rp)
    call t%check_close('d_sigma', o%d_sigma, 1.7_rp)
    call t%check_close('c_c', o%c_c, 0.41_rp)
    call t%check_close('c_1', o%c_1, 0.11_rp)
    call t%check_close('c_mu', o%c_mu, 0.12_rp)
    call t%check_close('alpha_minus', o%alpha_minus, 0.7_rp)
    call t%check_close('tolfacupx', o%tolfacupx, 77.0_rp)
    call t%check_close('tolupsigma', o%tolupsigma, 1.0e7_rp)
    call t%check('tolflatfitness', o%tolflatfitness == 5)
    call t%check('weights are the usual ones', o%weights == WEIGHTS_ACTIVE)
  end associate
  call read_settings('weights = positive;'//NL)
  call t%check('weights', s%search%weights == WEIGHTS_POSITIVE)
  call check_paper()
  call know_all_keys()
  call t%finish()

contains

  !> Truong et al.: 16 candidates, a linear box with joints from 0.1 to 1000 mN cm/rad, an end at h < 1e-4 cm or after 100
  !> generations, E fixed in a second search, nothing behind it.
  subroutine check_paper()
    integer :: i
    call read_settings('', 'preset = paper;'//NL)
    associate (o => s%search)
      call t%check('paper: lambda', o%lambda == 16)
      call t%check('paper: weights and constants', o%weights == WEIGHTS_PAPER .and. o%constants == CONSTANTS_PAPER)
      call t%check('paper: generations', o%max_iterations == 100)
      call t%check('paper: evaluations without limit', o%max_evaluations > 1600)
      call t%check_close('paper: target [m]', o%f_target, 1.0e-6_rp)
      call t%check_close('paper: tolfun', o%tolfun, 1.0e-11_rp)
    end associate
    call t%check('paper: two stages, no polish', s%n_stages == 2 .and. .not. s%polish)
    call t%check('paper: cross-springs', s%wing_case%requested%cross_springs)
    call t%check('paper: h, in a linear box', .not. s%use_chi2 .and. .not. any(s%free_parameters%is_log))
    do i = 1, s%free_parameters%count()
      if (s%free_parameters%numbers(i) == PARAM_YOUNG) cycle
      call t%check_close('paper: lower bound of a joint [N m/rad]', s%free_parameters%lower(i), 1.0e-6_rp)
      call t%check_close('paper: upper bound of a joint [N m/rad]', s%free_parameters%upper(i), 1.0e-2_rp)
    end do
    call t%check('paper: E and ten joints', s%free_parameters%count() == 11)
    call read_settings('lambda = 9;'//NL//'tolfun = 1e-5;'//NL//'target = 2e-6;'//NL, &
                       'preset = paper;'//NL//'stages = 1;'//NL)
    associate (o => s%search)
      call t%check('what is given counts before the paper', o%lambda == 9 .and. s%n_stages == 1)
      call t%check_close('tolfun counts before the paper', o%tolfun, 1.0e-5_rp)
      call t%check_close('target counts before the paper', o%f_target, 2.0e-6_rp)
    end associate
  end subroutine check_paper

  !> A load, and heights that it does not change.
  subroutine write_flat_measurement(path)
    character(*), intent(in) :: path
    integer, parameter :: NX = 6, NY = 4
    type(measurement_t) :: m
    type(failure_t) :: failure
    integer :: i, j
    allocate (m%x(NX), m%y(NY), m%unloaded(NX, NY), m%unloaded_sigma(NX, NY), m%has_unloaded(NX, NY), m%loads(1), &
              m%observations(0), m%zeros(0))
    m%x = [(1.0e-3_rp*i, i=1, NX)]
    m%y = [(0.5e-3_rp*j - 2.0e-3_rp, j=1, NY)]
    m%unloaded = 0
    m%unloaded_sigma = 1.0e-6_rp
    m%has_unloaded = .true.
    m%accuracy%height = 1.0e-6_rp
    associate (load => m%loads(1))
      load%name = 'load'
      load%force = 1.0e-4_rp
      load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
      load%point = [0.00721_rp, -0.00032_rp]
      load%node = reshape([((i, j, i=1, NX), j=1, NY)], [2, NX*NY])
      allocate (load%height(NX*NY), source=0.0_rp)
      allocate (load%sigma(NX*NY), source=m%accuracy%height)
    end associate
    call write_measurement(path, m, failure)
    call t%check('a measurement is written', .not. failure%failed)
  end subroutine write_flat_measurement

  !> Fills `s` from an ini file with these lines in [CMAES], and others in [Train].
  subroutine read_settings(lines, others)
    character(*), intent(in) :: lines
    character(*), intent(in), optional :: others
    character(:), allocatable :: train
    type(message_list_t) :: errors, notices
    type(failure_t) :: failure
    character(1000) :: wing
    call get_command_argument(1, wing)
    train = ''
    if (present(others)) train = '[Train]'//NL//others
    call write_text('train.ini', '[Wing]'//NL//'file = '//trim(wing)//';'//NL//'[Measurement]'//NL// &
                    'file = flat.h5;'//NL//train//'[CMAES]'//NL//lines, failure)
    call load_train_settings('train.ini', 1, .true., t%world, s, errors, notices)
    call t%check('the input is valid', .not. failure%failed .and. errors%count() == 0)
  end subroutine read_settings

  !> A key that is added must be added here.
  subroutine know_all_keys()
    type(registry_t) :: registry
    integer :: i, n_keys
    call register_train_keys(registry)
    n_keys = 0
    do i = 1, registry%n_keys
      associate (key => registry%keys(i)%key)
        if (key%section /= 'CMAES') cycle
        n_keys = n_keys + 1
        call t%check('a value is given for '//key%name, key%name == 'weights' .or. any(NAMES == key%name))
      end associate
    end do
    call t%check('all '//number_text(N + 1)//' keys are registered', n_keys == N + 1)
  end subroutine know_all_keys
end program test_train_settings
