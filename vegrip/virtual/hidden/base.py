"""What a hidden effect may change in a trial; each method leaves things as they are."""

from vegrip.virtual.relaxation import Relaxation


class Hidden:
    """Something that the simulated fingertip has beyond the plain one. All quantities are scalars, SI."""

    compliance = 0.0
    """Of what carries the tip [m/N]."""

    def start(self, pause: float) -> None:
        """Begin an episode after ``pause`` [s] of rest, in which what recovers has recovered."""

    def relaxation(self, g: Relaxation) -> Relaxation:
        """Return the reduced relaxation function of the material."""
        return g

    def moved(self, position: float) -> float:
        """Return how far the mount of the tip moves [m] when the drive stands at ``position``."""
        return position

    def drive(self, mount: float) -> float:
        """Return where the drive stands [m] when the mount is at ``mount``; the inverse of :meth:`moved`."""
        return mount

    def indentation(self, x: float) -> float:
        """Return the indentation that the material feels [m] of the geometric one."""
        return x

    def elastic(self, force: float, x: float) -> float:
        """Return the elastic force [N] at the indentation ``x`` that is felt."""
        return force

    def more(self, x: float, elastic: float) -> float:
        """Return what the material pushes more [N] at the end of a step than its relaxing past tells.

        There the indentation is ``x`` [m] and the elastic force ``elastic`` [N].
        """
        return 0.0

    def pull(self, x: float) -> float:
        """Return the attraction of the surfaces [N] at indentation ``x``; negative x is a gap."""
        return 0.0

    def remember(self, x: float, force: float, dt: float) -> None:
        """Close a step of ``dt`` [s] that ended at indentation ``x`` [m] and normal force ``force`` [N]."""

    def strained(self, elastic: float, x: float, dt: float) -> None:
        """Close a step of ``dt`` [s] that ended at the elastic force ``elastic`` [N], indentation ``x``."""

    def warmed(self, temperature: float) -> None:
        """Take the temperature [degrees Celsius] of the coming episode."""

    def radius(self, a: float, x: float, tip_radius: float) -> float:
        """Return the contact radius [m]."""
        return a

    def flattened(self, k: float) -> float:
        """Return the pressure exponent [-]."""
        return k

    def friction(self, mu: float, force: float, speed: float) -> float:
        """Return the friction coefficient at normal force [N] and slip speed [m/s] of the step before."""
        return mu

    def rubbed(self, force: float, speed: float, dt: float) -> None:
        """Close the tangential step of ``dt`` [s] in which the patch slid at ``speed`` [m/s]."""

    def sensed(self, shown: float, tangential: float, dt: float) -> float:
        """Return what the normal force sensor shows [N]; called once in every step."""
        return shown
