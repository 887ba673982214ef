"""Structures that another program computes, coupled by preCICE."""
