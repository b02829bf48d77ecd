"""The methods: each one answer to what a ray mesh sees."""

from anamorph.methods.protocol import Method as Method
from anamorph.methods.registry import METHODS as METHODS
from anamorph.methods.session import Session as Session
from anamorph.methods.specification import Specification as Specification
