"""Laws that no catalogue has, drafted from what a model leaves of a recording."""

from vegrip.identification.draft.search import Draft, draft

__all__ = ["Draft", "draft"]
