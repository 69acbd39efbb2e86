"""Engines that are judged themselves, one adapter a file: functions named in `validation.subject.QUESTIONS`."""
