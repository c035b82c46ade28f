! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes how a measured natural mode decays (solid_decay): its damping ratio, and the frequency if the wing relaxes. The mode is
!> v = sum of beta_i phi_i over the computed modes with which it is paired, with |beta| = 1.
module measurement_mode_damping
  use base_kinds, only: rp
  use measurement_modes, only: measured_mode_t
  use solid_damping_effects, only: damping_effects_t, DAMPING_RELAXATION
  use solid_decay, only: decay_t
  implicit none
  private
  public :: mode_damping_t

  type :: mode_damping_t
    logical :: is_measured = .false.
    real(rp) :: measured = 0, sigma = 1    !< damping ratio and its sd
    type(decay_t) :: decay                 !< computed
    type(damping_effects_t), private :: effects
    real(rp), private :: lambda = 1        !< [1/s^2]
    real(rp), private :: joint = 0         !< [1/s^2] J = v K_joints v
    real(rp), allocatable, private :: beta(:)
    real(rp), allocatable, private :: rubbed(:, :) !< (3, n_all) K_joints v; not allocated without joints
    real(rp), allocatable, private :: products(:)  !< of the modes with it
  contains
    procedure :: init => damping_init
    procedure :: find => damping_find
    procedure :: slopes => damping_slopes
    procedure :: effect_slopes => damping_effect_slopes
  end type mode_damping_t

contains

  !> Takes the damping ratio of a checked mode, if it has one.
  subroutine damping_init(self, mode)
    class(mode_damping_t), intent(out) :: self
    type(measured_mode_t), intent(in) :: mode
    self%is_measured = mode%damping >= 0
    if (.not. self%is_measured) return
    self%measured = mode%damping
    self%sigma = mode%damping_sigma
  end subroutine damping_init

  !> Finds the decay of a mode of this lambda with factors beta(m) of any length on the modes shapes(3, n_all, m), on which joints
  !> have the forces bent(3, n_all, m); of size 0 without joints.
  subroutine damping_find(self, effects, lambda, beta, bent, shapes)
    class(mode_damping_t), intent(inout) :: self
    type(damping_effects_t), intent(in) :: effects
    real(rp), intent(in) :: lambda, beta(:), bent(:, :, :), shapes(:, :, :)
    integer :: i
    self%effects = effects
    self%lambda = lambda
    self%beta = beta/norm2(beta)
    self%joint = 0
    if (allocated(self%rubbed)) deallocate (self%rubbed)
    if (size(bent) > 0) then
      allocate (self%rubbed(3, size(shapes, 2)), source=0.0_rp)
      do i = 1, size(beta)
        self%rubbed = self%rubbed + self%beta(i)*bent(:, :, i)
      end do
      self%products = [(sum(shapes(:, :, i)*self%rubbed), i=1, size(beta))]
      self%joint = dot_product(self%beta, self%products)
    end if
    call self%decay%init(lambda, self%joint, effects)
  end subroutine damping_find

  !> Returns the change of the logarithm of the frequency and of the damping ratio by a change d_lambda, changes of the modes
  !> shapes(3, n_all, m), and of their factors dbeta(m), of the length of those in `find`. K_joints changes by rubbing(m, m)
  !> between the modes.
  function damping_slopes(self, d_lambda, rubbing, shapes, dbeta) result(slopes)
    class(mode_damping_t), intent(in) :: self
    real(rp), intent(in) :: d_lambda, rubbing(:, :), shapes(:, :, :), dbeta(:)
    real(rp) :: slopes(2), change
    integer :: i
    change = 0
    if (allocated(self%rubbed)) then
      do i = 1, size(dbeta)
        change = change + 2*(self%beta(i)*sum(shapes(:, :, i)*self%rubbed) + dbeta(i)*self%products(i))
      end do
      change = change - 2*self%joint*dot_product(self%beta, dbeta) + dot_product(self%beta, matmul(rubbing, self%beta))
    end if
    slopes = self%decay%slope_of_mode(d_lambda, change)
  end function damping_slopes

  !> Returns the same change by damping effect `number`; see motion_simulation_t.
  function damping_effect_slopes(self, number, time) result(slopes)
    class(mode_damping_t), intent(in) :: self
    integer, intent(in) :: number
    real(rp), intent(in) :: time
    type(damping_effects_t) :: other
    type(decay_t) :: decay
    real(rp) :: slopes(2)
    decay = self%decay
    if (number == DAMPING_RELAXATION .and. abs(time - self%effects%relaxation_time) > 1.0e-12_rp*time) then
      other = self%effects
      other%relaxation = 0 ! the wing has only one
      other%relaxation_time = time
      call decay%init(self%lambda, self%joint, other)
    end if
    slopes = decay%slope_of_damping(number)
  end function damping_effect_slopes
end module measurement_mode_damping
