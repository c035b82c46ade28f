! SPDX-License-Identifier: GPL-3.0-or-later
!> Keys of thickness and smoothing of wings.
program test_mask_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fsi_mask_keys, only: mask_choices_t, mask_keys, read_mask_keys
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use spectral_grid, only: make_grid
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = new_line('a')
  type(testkit_t) :: kit
  call kit%start(parallel=.false.)
  ! dx = (0.1, 0.2, 0.1): the largest one counts without keys, and yl/ny where a key says dx.
  call expect('the default is t = 4 max(dx), h = max(dx)', '', 0.4_rp, 0.2_rp)
  call expect('WingThickness is the whole thickness', '[Insects]'//NL//'WingThickness=0.6', 0.3_rp, 0.2_rp)
  call expect('t_wing is the half', '[Flexible_wing]'//NL//'t_wing=3*dx', 0.6_rp, 0.2_rp)
  call expect('the smoothing may be given', '[Flexible_wing]'//NL//'wing_smoothing=0.5*dx', 0.4_rp, 0.1_rp)
  call expect('both names may say the same', '[Insects]'//NL//'WingThickness=0.6'//NL//'[Flexible_wing]'//NL// &
              't_wing=0.3', 0.3_rp, 0.2_rp)
  call expect('both names may not contradict', '[Insects]'//NL//'WingThickness=0.6'//NL//'[Flexible_wing]'//NL// &
              't_wing=0.6', 0.3_rp, 0.2_rp, '[Flexible_wing] t_wing:')
  call expect('the smoothing shrinks with the sheet, as FLUSI''s files need it', '[Insects]'//NL//'WingThickness=0.3', &
              0.15_rp, 0.15_rp)
  call expect('a sheet thinner than the grid spacing is refused', '[Insects]'//NL//'WingThickness=0.19', 0.095_rp, &
              0.2_rp, '[Insects] WingThickness:')
  call expect('under both names', '[Flexible_wing]'//NL//'t_wing=0.09', 0.09_rp, 0.2_rp, '[Flexible_wing] t_wing:')
  call expect('a smoothing wider than the sheet shrinks to it', '[Flexible_wing]'//NL//'wing_smoothing=0.5', 0.4_rp, 0.4_rp)
  call expect('where wings may be soft, the smoothing is max(dx)', '[Insects]'//NL//'WingThickness=0.3', 0.15_rp, 0.2_rp, &
              soft=.true.)
  call expect('there it may be given', '[Flexible_wing]'//NL//'wing_smoothing=0.5', 0.4_rp, 0.5_rp, soft=.true.)
  call expect('but the mask must see them', '[Insects]'//NL//'WingThickness=0.19', 0.095_rp, 0.2_rp, &
              '[Insects] WingThickness:', soft=.true.)
  call expect('a thickness of 0 is refused', '[Flexible_wing]'//NL//'t_wing=0', 0.4_rp, 0.2_rp, &
              '[Flexible_wing] t_wing:')
  call kit%finish()

contains

  !> Values from `text`; with `mistake` there must be a message that holds it, without there must be none.
  subroutine expect(sentence, text, half, smoothing, mistake, soft)
    character(*), intent(in) :: sentence, text
    real(rp), intent(in) :: half, smoothing
    character(*), intent(in), optional :: mistake
    logical, intent(in), optional :: soft
    type(registry_t), target :: registry
    type(keys_t) :: keys
    type(mask_choices_t) :: unused
    type(config_t) :: config
    type(message_list_t) :: errors, notices
    real(rp) :: got(2)
    logical :: right
    keys = declaring(registry)
    call mask_keys(keys, unused)
    call registry%add_integer('Resolution', 'ny', 10, 'points')
    call registry%add_real('Geometry', 'yl', 2.0_rp, 'length')
    call registry%set_lattice('Resolution', 'ny', 'Geometry', 'yl')
    call config%load_text('[Resolution]'//NL//'ny=10'//NL//text//NL, 'run.ini', registry, errors, notices)
    call read_mask_keys(config, make_grid([10, 10, 10], [1.0_rp, 2.0_rp, 1.0_rp]), got(1), got(2), errors, &
                        notices, soft)
    if (present(mistake)) then
      right = errors%count() == 1
      if (right) right = index(errors%text(1), mistake) > 0
      call kit%check(sentence//': one message', right)
    else
      call kit%check(sentence//': no message', errors%count() == 0)
    end if
    call kit%check(sentence//': values', all(abs(got - [half, smoothing]) <= 1.0e-14_rp))
  end subroutine expect
end program test_mask_keys
