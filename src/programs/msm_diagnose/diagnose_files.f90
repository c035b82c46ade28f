! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the files of a diagnosis other than NAME.json: the wing of the baseline and the extended wing as fragments for
!> [include], and the maps.
module diagnose_files
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_errors, only: failure_t
  use base_files, only: remove_file
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_text_file, only: write_text
  use common_instrument, only: instrument_lines
  use common_wing_fragment, only: wing_lines
  use diagnose_modes, only: mass_lines, write_mode_tables
  use diagnose_series, only: damping_lines, write_series_tables
  use diagnose_settings, only: diagnose_settings_t
  use diagnose_summary, only: cause_name, verdict_sentence
  use diagnosis_families, only: FAMILIES
  use diagnosis_wing_parameters, only: fit_case_coordinates, fit_case_params, fit_case_t, is_hinge_of_piece, KIND_SOFT
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_decision, only: verdict_word
  use inference_engine, only: diagnosis_t
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_table, only: put_table
  use solid_params, only: solid_params_t
  use solid_wing_refine, only: coarsen_params, equal_rotation
  implicit none
  private
  public :: wing_text, write_fragments, write_maps

  character(*), parameter :: NL = new_line('a')

contains

  !> Writes NAME_baseline.ini and, if a cause was found, NAME_extended.ini. If none was found, it removes the NAME_extended.ini of
  !> another diagnosis. The values are for the mesh in the wing file. If they were fitted on a finer mesh, the wing in these files
  !> differs from the fit by the error of the mesh.
  subroutine write_fragments(s, d, failure)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: what
    integer :: i
    call write_fragment(s, d%initial_baseline%q, 'baseline of a diagnosis', s%name//'_baseline.ini', failure)
    if (.not. d%extended%is_found) then
      call remove_file(s%name//'_extended.ini')
      return
    end if
    what = 'diagnosis: '//verdict_word(d%decision%verdict)//', '//verdict_sentence(s, d)//NL//'; extended by'
    do i = 1, size(d%decision%causes)
      what = what//' '//cause_name(s, d, i)//';'
    end do
    call write_fragment(s, d%extended%q, what(:len(what) - 1), s%name//'_extended.ini', failure)
  end subroutine write_fragments

  !> Writes the parameters `q` as an input file that others can include. `what` says what they are.
  subroutine write_fragment(s, q, what, path, failure)
    type(diagnose_settings_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    character(*), intent(in) :: what, path
    type(failure_t), intent(inout) :: failure
    type(fit_case_t) :: fit_case
    type(solid_params_t) :: params
    character(:), allocatable :: mesh
    call fit_case_params(s%experiment, s%wing_case%wing, s%catalogue%parameters, q, fit_case, params)
    mesh = ''
    if (s%fits_finer) mesh = '; fitted on a mesh of half the size'//NL
    call write_text(path, '; Stiffness of '//s%wing_case%path//' from '//s%measurement_path//NL//'; by msm_diagnose '// &
                    BUILD_VERSION//' ('//BUILD_COMMIT//'): '//what//NL//mesh//'; [include] file = '//path//NL//NL// &
                    lines_of(s, q, params)// &
                    instrument_lines(fit_case%experiment%instrument_at(fit_case_coordinates(fit_case, q))), failure)
  end subroutine write_fragment

  !> Returns the sections of an input file that make the wing with the parameters `q`, for the mesh in the wing file.
  function wing_text(s, q) result(text)
    type(diagnose_settings_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    character(:), allocatable :: text
    type(fit_case_t) :: fit_case
    type(solid_params_t) :: params
    call fit_case_params(s%experiment, s%wing_case%wing, s%catalogue%parameters, q, fit_case, params)
    text = lines_of(s, q, params)
  end function wing_text

  !> Returns the sections [Wing], [Mass] and [Damping] of the wing with the parameters `q`, of which `params` are its stiffness. A
  !> joint without a stiffness in [Wing] bends as its vein does on each mesh, and what it turns beside that is the same on both; so
  !> do a soft place and the root.
  function lines_of(s, q, params) result(text)
    type(diagnose_settings_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    type(solid_params_t), intent(in) :: params
    character(:), allocatable :: text
    type(solid_params_t) :: of_file
    integer :: i
    of_file = params
    if (s%fits_finer) then
      of_file = coarsen_params(params)
      do i = 1, size(params%joint)
        of_file%joint(i) = equal_rotation(params%joint(i), s%experiment%model%params%joint(i), s%file_requested%joint(i))
      end do
      do i = 1, size(q)
        associate (p => s%catalogue%parameters(i))
          if (.not. abs(q(i) - p%null) > 0) cycle
          if (is_hinge_of_piece(p, s%experiment%model%params)) call of_file%set_named(p%name, exp(p%on_file%at(q(i))))
          if (p%kind == KIND_SOFT) of_file%effects%soft_fraction = p%file_fraction
        end associate
      end do
    end if
    text = wing_lines(of_file, s%wing_case)//mass_lines(s, q)//damping_lines(s, q)
  end function lines_of

  !> Writes NAME.h5. For each load it holds the averages with the residuals of the baseline and of the extended wing, as they are
  !> and whitened. It also holds the tables of modes and of records of motion, and a map of where on the wing an unknown cause would
  !> act.
  subroutine write_maps(s, simulator, d, failure)
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    real(rp), allocatable :: rows(:, :), base(:), extended(:), jacobian(:, :), white(:, :)
    integer :: l, k, n, first
    logical :: is_valid
    n = simulator%n_observations
    allocate (base(n), extended(n), jacobian(n, 0), white(n, 2))
    call simulator%evaluate(d%initial_baseline%q, [integer ::], d%model%baseline%state, base, jacobian, is_valid)
    extended = base
    if (d%extended%is_found) &
      call simulator%evaluate(d%extended%q, [integer ::], d%extended%state, extended, jacobian, is_valid)
    white(:, 1) = base
    white(:, 2) = extended
    call d%model%whitener%apply(white)
    call file%create_serial(s%name//'.h5.part', failure)
    call put_attribute(file, '/', 'schema', 'flusi-msm diagnosis', failure)
    call put_attribute(file, '/', 'version', 1, failure)
    call put_attribute(file, '/', 'wing', s%wing_case%path, failure)
    call put_attribute(file, '/', 'measurement', s%measurement_path, failure)
    call file%make_group('/loads', failure)
    do l = 1, size(s%measurement%loads)
      first = s%bins%first(l)
      allocate (rows(7, s%bins%count(l)))
      do k = 1, size(rows, 2)
        associate (i => first + k - 1)
          rows(:, k) = [s%bins%site(:, i), simulator%labels%observed(i), base(i), extended(i), &
                        white(i, 1), white(i, 2)]
        end associate
      end do
      call put_table(file, '/loads/'//s%measurement%loads(l)%name, rows, &
                     'x y measured baseline extended baseline_white extended_white', failure)
      call put_attribute(file, '/loads/'//s%measurement%loads(l)%name, 'point', s%measurement%loads(l)%point, failure)
      call put_attribute(file, '/loads/'//s%measurement%loads(l)%name, 'force', s%measurement%loads(l)%force, failure)
      deallocate (rows)
    end do
    call write_mode_tables(file, s, failure)
    call write_series_tables(file, s, failure)
    call write_unknown(file, simulator, d, failure)
    call file%publish(s%name//'.h5', .false., failure)
  end subroutine write_maps

  !> Writes, with the site of each pattern, the posterior mean and sd of its strength from the whole misfit of the baseline, divided
  !> by the largest prior sd of all patterns.
  subroutine write_unknown(file, simulator, d, failure)
    type(hdf5_file_t), intent(in) :: file
    type(wing_simulator_t), intent(in) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: rows(:, :), mean(:), sd(:)
    integer :: f, k
    if (.not. allocated(d%tests%z)) return
    call file%make_group('/unknown', failure)
    do f = 1, size(d%model%design%families)
      call d%model%design%families(f)%posterior(d%tests%z, mean, sd)
      allocate (rows(4, size(mean)))
      do k = 1, size(mean)
        rows(:, k) = [simulator%pattern_site(:, d%model%design%families(f)%patterns(k)), mean(k), sd(k)]
      end do
      call put_table(file, '/unknown/'//word_of(FAMILIES, simulator%family_kinds(f)), rows, 'x y mean sd', failure)
      deallocate (rows)
    end do
  end subroutine write_unknown
end module diagnose_files
