"""What real sensors do and textbooks do not, an ingredient a function: in the order of the physics
(awkward.py).
"""
