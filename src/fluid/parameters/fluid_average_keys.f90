! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads which means over time a run gathers from the keys of [Averaging].
module fluid_average_keys
  use base_kinds, only: rp
  use io_keys, only: keys_t
  implicit none
  private
  public :: average_params_t, average_keys

  !> States which means the user wants, and from which time on.
  type :: average_params_t
    logical :: is_on = .false.
    logical :: velocity = .true., kinetic_energy = .false., enstrophy = .false.
    real(rp) :: begin = 0       !< T
    logical :: one_only = .true. !< the newest means replace earlier ones
  contains
    procedure :: n_fields => params_n_fields
  end type average_params_t

contains

  !> Declares and reads the keys of [Averaging].
  subroutine average_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(average_params_t), intent(inout) :: p
    call keys%section('Averaging', 'averages over time, computed during the run and saved with the fields')
    call keys%switch('time_avg', p%is_on, .false., 'compute averages over time')
    call keys%switch('vel_avg', p%velocity, .true., 'average the velocity: uavgx uavgy uavgz')
    call keys%switch('ekin_avg', p%kinetic_energy, .false., 'average |u|^2/2: ekinavg')
    call keys%switch('enstrophy_avg', p%enstrophy, .false., 'average |omega|^2/2: zavg')
    call keys%real('tstart_avg', p%begin, 0.0_rp, 'time at which averaging begins', unit='T', min=0.0_rp)
    call keys%switch('save_one_only', p%one_only, .true., 'new averages overwrite the previous ones, in files with the number '// &
                     '000; no: the files have the numbers of the fields')
    p%is_on = p%is_on .and. (p%velocity .or. p%kinetic_energy .or. p%enstrophy)
  end subroutine average_keys

  !> Returns the number of fields that are gathered.
  pure integer function params_n_fields(self) result(n)
    class(average_params_t), intent(in) :: self
    n = 0
    if (self%is_on) n = merge(3, 0, self%velocity) + count([self%kinetic_energy, self%enstrophy])
  end function params_n_fields
end module fluid_average_keys
