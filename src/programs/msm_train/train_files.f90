! SPDX-License-Identifier: GPL-3.0-or-later
!> Handles several individuals in one input: reads the lists of files and names the files of each individual.
module train_files
  use base_errors, only: message_list_t
  use base_files, only: name_of
  use base_text, only: count_words, next_word, number_text, quoted
  use io_config, only: config_t
  use io_broadcast_text, only: named_path
  use parallel_world, only: world_t
  implicit none
  private
  public :: choose_individual, individual_files, of_individual

contains

  !> Chooses the wing and the measurement of individual `number`. `wing` and `measurement` are the lists in [Wing] file (one wing
  !> for all individuals, or one for each) and [Measurement] file, with commas between the items; when it returns, they are the
  !> files of this individual. `individual` is the name of the individual: that of its measurement without folder and ending, or
  !> empty if there is only one. `n_individuals` is the number of measurements, at least 1. A mistake goes to `errors` if the lists
  !> do not fit together or two measurements have the same name.
  subroutine choose_individual(config, number, wing, measurement, n_individuals, individual, errors)
    type(config_t), intent(in) :: config
    integer, intent(in) :: number
    character(:), allocatable, intent(inout) :: wing, measurement
    integer, intent(out) :: n_individuals
    character(:), allocatable, intent(out) :: individual
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: wings, measurements
    integer :: n_wings, i, k
    wings = wing
    measurements = measurement
    n_wings = count_words(wings, ',')
    n_individuals = max(1, count_words(measurements, ','))
    individual = ''
    wing = item(wings, merge(number, 1, n_wings > 1))
    measurement = item(measurements, number)
    if (n_wings > 1 .and. n_wings /= n_individuals) &
      call config%complain(errors, 'Wing', 'file', number_text(n_wings)//' wings, but '//number_text(n_individuals)// &
                           ' measurements: name one wing for all, or one for each')
    if (n_individuals == 1) return
    individual = stem_of(measurement)
    do i = 2, n_individuals
      do k = 1, i - 1
        if (number > 1 .or. stem_of(item(measurements, i)) /= stem_of(item(measurements, k))) cycle
        call config%complain(errors, 'Measurement', 'file', 'two measurements are called '// &
                             quoted(stem_of(item(measurements, i)))// &
                             ', and their results have the names of the measurements: rename one')
        return
      end do
    end do
  end subroutine choose_individual

  !> Adds to `paths` the paths of the wings and measurements in two lists of the input file `ini`. A path is empty
  !> where there is no such file. Collective.
  subroutine individual_files(wings, measurements, ini, world, paths)
    character(*), intent(in) :: wings, measurements, ini
    type(world_t), intent(in) :: world
    type(message_list_t), intent(inout) :: paths
    call add_paths(wings)
    call add_paths(measurements)

  contains

    subroutine add_paths(list)
      character(*), intent(in) :: list
      integer :: i
      do i = 1, count_words(list, ',')
        call paths%add(named_path(item(list, i), ini, world))
      end do
    end subroutine add_paths
  end subroutine individual_files

  !> Returns the name of a file of this individual. `individual` is inserted before `ending`, or appended to a name with another
  !> ending.
  pure function of_individual(name, individual, ending) result(own)
    character(*), intent(in) :: name, individual, ending
    character(:), allocatable :: own
    integer :: n
    own = name
    if (individual == '' .or. name == '') return
    n = len(name) - len(ending)
    own = name//'_'//individual
    if (n < 1) return
    if (name(n + 1:) == ending) own = name(:n)//'_'//individual//ending
  end function of_individual

  !> Returns item k of a list without the blanks around it. It is empty if the list is shorter.
  function item(list, k) result(text)
    character(*), intent(in) :: list
    integer, intent(in) :: k
    character(:), allocatable :: text
    integer :: position, first, last, i
    logical :: found
    text = ''
    position = 1
    do i = 1, k
      call next_word(list, ',', position, first, last, found)
      if (.not. found) return
    end do
    text = trim(adjustl(list(first:last)))
  end function item

  !> Returns the name of a file without its folder and its ending.
  function stem_of(path) result(stem)
    character(*), intent(in) :: path
    character(:), allocatable :: stem
    integer :: dot
    stem = name_of(path)
    dot = index(stem, '.', back=.true.)
    if (dot > 1) stem = stem(:dot - 1)
  end function stem_of
end module train_files
