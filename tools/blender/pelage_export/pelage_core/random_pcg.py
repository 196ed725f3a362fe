"""The random generator of include/pelage/random.h, which gives the same numbers everywhere."""

_MASK64 = (1 << 64) - 1
_MASK32 = (1 << 32) - 1


class Random:
    """PCG32, variant XSH-RR 64/32: O'Neill, "PCG: A Family of Simple Fast Space-Efficient
    Statistically Good Algorithms for Random Number Generation" (2014)."""

    def __init__(self, seed, stream=0):
        self._state = 0
        self._increment = (stream << 1 | 1) & _MASK64
        self.bits()
        self._state = (self._state + seed) & _MASK64
        self.bits()

    def bits(self):
        """32 random bits."""
        old = self._state
        self._state = (old * 6364136223846793005 + self._increment) & _MASK64
        mixed = ((old >> 18 ^ old) >> 27) & _MASK32
        turn = old >> 59
        return (mixed >> turn | mixed << (32 - turn) % 32) & _MASK32

    def below(self, count):
        """Uniform integer in [0, count), without bias; 0 when count is 0."""
        if count == 0:
            return 0
        # Reject the incomplete last block of residues.
        first = (1 << 32) % count
        value = self.bits()
        while value < first:
            value = self.bits()
        return value % count

    def permutation(self, count):
        """The numbers 0..count-1 in random order (Fisher and Yates, from the back)."""
        order = list(range(count))
        for last in range(count - 1, 0, -1):
            other = self.below(last + 1)
            order[last], order[other] = order[other], order[last]
        return order
