! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes causes that are not in the catalogue: families of patterns, each with an unknown amplitude of a Gaussian prior.
module inference_families
  use base_kinds, only: rp
  use base_lapack, only: decompose
  use inference_effect_size, only: effect_variance, effect_size_prior_t
  use inference_simulator, only: simulator_t
  implicit none
  private
  public :: family_t, make_families

  !> Unknown causes of one kind: smooth fields with a Gaussian prior.
  type :: family_t
    integer, allocatable :: patterns(:)     !< indices of the simulator's patterns
    real(rp), allocatable :: basis(:, :)    !< (k, m) principal directions
    real(rp), allocatable :: scale(:)       !< (m) their sd for unit strength, the largest is 1
    real(rp), allocatable :: weights(:, :)  !< (patterns, m) pattern amplitudes of unit strength
    real(rp), allocatable :: alone(:, :)    !< (k, shown) single patterns of length 1 that the baseline does not absorb
    integer, allocatable :: shown(:)        !< which of `patterns` they are
    type(effect_size_prior_t) :: size_prior_alone
    type(effect_size_prior_t) :: size_prior
  contains
    procedure :: posterior => family_posterior
  end type family_t

contains

  !> Makes the families of patterns of unknown causes: principal directions, priors and the patterns shown alone. retained(k, :)
  !> are the remainders of the patterns and of the tangents of the simulator's field.
  subroutine make_families(simulator, retained, families)
    class(simulator_t), intent(in) :: simulator
    real(rp), intent(in) :: retained(:, :)
    type(family_t), allocatable, intent(out) :: families(:)
    real(rp), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: f, i, m
    m = 0
    if (size(retained, 2) > 0) m = maxval(simulator%family)
    allocate (families(m))
    do f = 1, m
      associate (one => families(f))
        one%patterns = pack([(i, i=1, size(retained, 2))], simulator%family == f)
        call decompose(retained(:, one%patterns), u, s, vt)
        i = count(s > 1.0e-6_rp*maxval(s))
        one%basis = u(:, :i)
        one%scale = s(:i)/maxval(s)
        one%weights = transpose(vt(:i, :))/maxval(s)
        call one%size_prior%init(one%scale)
        call one%size_prior_alone%init([1.0_rp])
        one%shown = pack([(i, i=1, size(one%patterns))], one%patterns <= min(simulator%n_patterns, simulator%n_alone) &
                         .and. norm2(retained(:, one%patterns), 1) > 1.0e-6_rp*maxval(s))
        one%alone = retained(:, one%patterns(one%shown))
        do i = 1, size(one%alone, 2)
          one%alone(:, i) = one%alone(:, i)/norm2(one%alone(:, i))
        end do
      end associate
    end do
  end subroutine make_families

  !> Returns the posterior mean(patterns) and sd(patterns) of the amplitudes, given z(k), at the most likely common strength.
  subroutine family_posterior(self, z, mean, sd)
    class(family_t), intent(in) :: self
    real(rp), intent(in) :: z(:)
    real(rp), allocatable, intent(out) :: mean(:), sd(:)
    real(rp) :: w(size(self%scale)), tau, largest, resolved
    integer :: i
    w = matmul(z, self%basis)
    tau = effect_variance(maxloc(matmul(w**2, self%size_prior%gain) - self%size_prior%offset, 1))
    mean = matmul(self%weights, tau*self%scale/(1 + tau*self%scale**2)*w)
    ! The columns of weights have the length of one over the largest singular value.
    largest = 1/maxval(norm2(self%weights, 1))
    allocate (sd(size(mean)))
    do i = 1, size(sd)
      resolved = sum(self%weights(i, :)**2*tau*(tau*self%scale**2/(1 + tau*self%scale**2)))
      sd(i) = sqrt(max(0.0_rp, tau/largest**2 - resolved))
    end do
  end subroutine family_posterior
end module inference_families
