"""Hosts, as addresses name them."""

from __future__ import annotations

from ipaddress import ip_address


def is_this_machine(host: str) -> bool:
    """Whether only this machine is reached by a name or an address of a host."""
    try:
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        return False
