"""Rows about contact: what falls, is pulled, hit, worn and rubbed, judged by the IPC Toolkit and by NumPy."""
