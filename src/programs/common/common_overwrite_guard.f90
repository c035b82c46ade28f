! SPDX-License-Identifier: GPL-3.0-or-later
!> Refuses outputs that would overwrite inputs.
module common_overwrite_guard
  use base_errors, only: message_list_t
  use base_files, only: file_exists, real_path
  use io_config, only: config_t
  implicit none
  private
  public :: refuse_overwriting

contains

  !> Adds a mistake on [section] key if writing `output` would overwrite the file of `config`, a file that it reads, or one of
  !> `inputs`.
  subroutine refuse_overwriting(config, section, key, output, inputs, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: section, key
    character(*), intent(in) :: output
    type(message_list_t), intent(in) :: inputs !< paths; empty ones are ignored
    type(message_list_t), intent(inout) :: errors
    logical :: is_input
    integer :: i
    if (output == '') return
    if (.not. file_exists(output)) return
    is_input = config%reads(output)
    do i = 1, inputs%count()
      if (inputs%text(i) /= '') is_input = is_input .or. real_path(output) == real_path(inputs%text(i))
    end do
    if (is_input) call config%complain(errors, section, key, output//' is an input file and would be '// &
                                       'overwritten: choose another name')
  end subroutine refuse_overwriting
end module common_overwrite_guard
